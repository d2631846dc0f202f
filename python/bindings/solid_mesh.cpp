// Bindings of solid meshes of all element types: generation, refinement by order, boundary, volumes.
#include <nanobind/nanobind.h>
#include <nanobind/stl/array.h>
#include <nanobind/stl/string.h>
#include <nanobind/stl/tuple.h>

#include "solid_mesh.h"

namespace {

namespace nb = nanobind;
using namespace nb::literals;
using namespace stark;
using namespace stark::bindings;

/// Mesh with indices in range.
SolidMesh solid_mesh(nb::handle vertices, nb::handle elements) {
  SolidMesh mesh;
  const auto points = array<Rows<double, 3>>(vertices, "vertices", "an (n, 3) array of positions [m]");
  const auto view = rows<Vec3>(points);
  mesh.vertices.assign(view.begin(), view.end());
  read_elements(elements, "elements", mesh);
  for (size_t k = 0; k < mesh.elements.size(); ++k)
    if (mesh.elements[k] < 0 || static_cast<size_t>(mesh.elements[k]) >= mesh.vertices.size())
      throw InvalidMesh("element " + std::to_string(k / mesh.node_count()) + " refers to vertex " +
                        std::to_string(mesh.elements[k]) + ": indices must be in [0, " +
                        std::to_string(mesh.vertices.size()) + ")");
  return mesh;
}

nb::tuple to_arrays(SolidMesh mesh) {
  const int64_t count = mesh.element_count();
  const nb::object flat = nb::cast(to_numpy<int32_t>(std::move(mesh.elements)));
  return nb::make_tuple(to_numpy<double>(std::move(mesh.vertices)),
                        flat.attr("reshape")(count, reference_element(mesh.type).node_count));
}

}  // namespace

void bind_solid_mesh(nb::module_& m) {
  m.def(
      "make_hex_box",
      [](const std::array<double, 3>& size, const Index3& cells) {
        return to_arrays(make_hex_box({size[0], size[1], size[2]}, cells));
      },
      "size"_a, "cells"_a, "(vertices, elements) of a box of hexahedra with 8 nodes.");
  m.def(
      "to_quadratic",
      [](nb::handle vertices, nb::handle elements) {
        return to_arrays(to_quadratic(solid_mesh(vertices, elements)));
      },
      "vertices"_a, "elements"_a, "(vertices, elements) with nodes between the corners.");
  m.def(
      "element_volumes",
      [](nb::handle vertices, nb::handle elements) {
        return to_numpy<double>(compute_element_volumes(solid_mesh(vertices, elements)));
      },
      "vertices"_a, "elements"_a, "Volume of each element [m^3].");
  m.def(
      "solid_boundary_triangles",
      [](nb::handle elements) {
        SolidMesh mesh;
        read_elements(elements, "elements", mesh);
        return to_numpy<int32_t>(find_boundary_triangles(mesh));
      },
      "elements"_a, "Triangles (k, 3) of the faces of one element only, outwards.");
  m.def(
      "element_name",
      [](nb::handle elements) {
        SolidMesh mesh;
        read_elements(elements, "elements", mesh);
        return std::string(reference_element(mesh.type).name);
      },
      "elements"_a, "Name of the element type that the number of columns stands for.");
}
