// Solid meshes from dictionaries of arrays: the number of columns says the type of the elements.
#pragma once

#include "functions.h"

namespace stark::bindings {

/// Sets type and elements of the mesh from an (m, 4), (m, 8), (m, 10) or (m, 27) array; throws
/// InvalidArgument for other shapes.
inline void read_elements(nb::handle object, const std::string& name, SolidMesh& mesh) {
  using Table = nb::ndarray<const int32_t, nb::ndim<2>, nb::c_contig, nb::device::cpu>;
  const auto table = array<Table>(object, name, "an array of shape (m, 4), (m, 8), (m, 10) or (m, 27)");
  for (const ElementType type :
       {ElementType::Tet4, ElementType::Tet10, ElementType::Hex8, ElementType::Hex27})
    if (static_cast<int>(table.shape(1)) == reference_element(type).node_count) {
      mesh.type = type;
      mesh.elements.assign(table.data(), table.data() + table.size());
      return;
    }
  throw InvalidArgument(name + ": got " + std::to_string(table.shape(1)) +
                        " nodes an element: must be 4, 8, 10 or 27");
}

/// From "vertices" (n, 3), "elements", and "embedding" of what the solid carries along: "cells" (k,),
/// "triangles" (m, 3) and "filling" (elements, 27).
inline SolidMesh solid_mesh(const Given& given) {
  SolidMesh mesh;
  given.read("vertices", mesh.vertices);
  read_elements(given["elements"], given.owner() + ": elements", mesh);
  if (const nb::object entries = given.find("embedding")) {
    const Given embedding(entries, given.owner());
    embedding.require("cells", "triangles", "filling");
    embedding.read("cells", mesh.embedding.elements, "an array of shape (k,)");
    embedding.read("triangles", mesh.embedding.triangles, "an array of shape (m, 3)");
    embedding.read("filling", mesh.embedding.fillings, "an array of shape (elements, 27)");
  }
  return mesh;
}

}  // namespace stark::bindings
