// Solid meshes from NumPy arrays: the number of columns says the type of the elements.
#pragma once

#include <string>

#include <stark/geometry/solid_mesh.h>

#include "given.h"

namespace stark::bindings {

/// Part, mean and mean square in a row.
template <>
struct NumbersOf<CellFilling> : NumbersOf<Vec3> {};

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

/// What a solid carries along, from the keys "cells" (k,), "triangles" (m, 3) and "filling" (elements, 7).
inline Embedding embedding_of(nb::handle entries, const std::string& owner) {
  const Given given(entries, owner);
  given.require("cells", "triangles", "filling");
  Embedding embedding;
  given.read("cells", embedding.elements, "an array of shape (k,)");
  given.read("triangles", embedding.triangles, "an array of shape (m, 3)");
  given.read("filling", embedding.fillings, "an array of shape (elements, 7)");
  return embedding;
}

/// (vertices, elements)
inline auto arrays_of_mesh(const SolidMesh& mesh) {
  const size_t count = mesh.element_count(), nodes = mesh.node_count();
  return std::pair(to_numpy(mesh.vertices), to_numpy(mesh.elements, {count, nodes}));
}

}  // namespace stark::bindings

template <>
struct nanobind::detail::type_caster<stark::SolidMesh>
    : OneWayCaster<stark::SolidMesh, stark::bindings::arrays_of_mesh> {};
