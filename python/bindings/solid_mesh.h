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
                        " nodes an element, need 4, 8, 10 or 27");
}

}  // namespace stark::bindings
