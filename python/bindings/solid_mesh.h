// Solid meshes from NumPy arrays: the number of columns says the type of the elements.
#pragma once

#include <string>

#include <stark/geometry/solid_mesh.h>

#include "arrays.h"

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

/// What a solid carries along, from the keys "cells" (k,), "triangles" (m, 3) and "filling" (elements, 7):
/// part, mean and mean square of each element.
inline Embedding embedding_of(const nb::dict& given, const std::string& owner) {
  Embedding embedding;
  using Filling = std::array<double, 7>;
  embedding.elements = numbers_of<int32_t>(given["cells"], owner + ": cells", "an array of shape (k,)");
  embedding.triangles =
      rows_of<Index3, int32_t, 3>(given["triangles"], owner + ": triangles", "an array of shape (m, 3)");
  for (const Filling& f :
       rows_of<Filling, double, 7>(given["filling"], owner + ": filling", "an array of shape (elements, 7)"))
    embedding.fillings.push_back({f[0], {f[1], f[2], f[3]}, {f[4], f[5], f[6]}});
  return embedding;
}

}  // namespace stark::bindings
