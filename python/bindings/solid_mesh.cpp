// Bindings of solid meshes of all element types: generation, refinement by order, boundary, volumes.
#include <nanobind/nanobind.h>
#include <nanobind/stl/array.h>
#include <nanobind/stl/string.h>
#include <nanobind/stl/tuple.h>

#include <stark/geometry/embedding.h>
#include <stark/geometry/lattice.h>

#include "casters.h"
#include "domains.h"
#include "solid_mesh.h"
#include "with_arrays.h"

namespace {

namespace nb = nanobind;
using namespace nb::literals;
using namespace stark;
using namespace stark::bindings;

/// Mesh with indices in range.
SolidMesh solid_mesh(nb::handle vertices, nb::handle elements) {
  SolidMesh mesh;
  mesh.vertices = points_of(vertices, "vertices", "an (n, 3) array of positions [m]");
  read_elements(elements, "elements", mesh);
  check_indices(mesh);
  return mesh;
}

nb::tuple to_arrays(SolidMesh mesh) {
  const size_t count = mesh.element_count(), nodes = reference_element(mesh.type).node_count;
  return nb::make_tuple(to_numpy(std::move(mesh.vertices)),
                        to_numpy(std::move(mesh.elements), {count, nodes}));
}

nb::tuple lattice(const std::vector<Vec3>& vertices, const std::vector<Index3>& triangles, double cell_size,
                  bool quadratic) {
  const TriangleMesh surface{vertices, triangles};
  SolidMesh mesh;
  {
    const nb::gil_scoped_release release;
    mesh = make_lattice(surface, cell_size, quadratic);
  }
  Embedding embedding = std::move(mesh.embedding);
  std::vector<std::array<double, 7>> filling;
  for (const CellFilling& f : embedding.fillings)
    filling.push_back({static_cast<double>(f.part), f.mean.x, f.mean.y, f.mean.z, f.mean_square.x,
                       f.mean_square.y, f.mean_square.z});
  return nb::make_tuple(to_arrays(std::move(mesh)), to_numpy(std::move(embedding.elements)),
                        to_numpy(std::move(embedding.triangles)), to_numpy(std::move(filling)));
}

auto weights_of(nb::handle vertices, nb::handle elements, const nb::dict& embedding) {
  SolidMesh mesh = solid_mesh(vertices, elements);
  mesh.embedding = embedding_of(embedding, "embedding_weights");
  const size_t nodes = mesh.node_count(), count = mesh.embedding.elements.size();
  std::vector<double> weights(count * nodes);
  for (size_t k = 0; k < count; ++k) embedding_weights(mesh, k, std::span(weights).subspan(k * nodes, nodes));
  return nb::cast(to_numpy(std::move(weights), {count, nodes}));
}

auto filled_volumes(nb::handle vertices, nb::handle elements, const nb::dict& embedding) {
  SolidMesh mesh = solid_mesh(vertices, elements);
  mesh.embedding = embedding_of(embedding, "filled_volumes");
  if (mesh.embedding.fillings.size() != static_cast<size_t>(mesh.element_count()))
    throw InvalidMesh("filled_volumes: filling: must have a row for each element");
  return to_numpy(compute_element_volumes(mesh));
}

/// A mesh of elements without vertices.
SolidMesh elements_alone(nb::handle elements) {
  SolidMesh mesh;
  read_elements(elements, "elements", mesh);
  return mesh;
}

}  // namespace

void bind_solid_mesh(nb::module_& m) {
  m.def(
      "make_hex_box",
      [](const Vec3& size, const Index3& cells) { return to_arrays(make_hex_box(size, cells)); }, "size"_a,
      "cells"_a, "(vertices, elements) of a box of hexahedra with 8 nodes.");
  m.def("make_lattice",
        with_arrays<lattice, "vertices: an (n, 3) array of positions [m]",
                    "triangles: an (m, 3) array of vertices">,
        "vertices"_a, "triangles"_a, "cell_size"_a, "quadratic"_a,
        "((vertices, elements), cells, triangles, filling) of a surface in a lattice of cubes.");
  m.def("filled_volumes", filled_volumes, "vertices"_a, "elements"_a, "embedding"_a,
        "Volume of what is filled of each element [m^3].");
  m.def("embedding_weights", weights_of, "vertices"_a, "elements"_a, "embedding"_a,
        "Shape functions of its element at each embedded vertex.");
  m.def(
      "to_quadratic", [](nb::handle x, nb::handle e) { return to_arrays(to_quadratic(solid_mesh(x, e))); },
      "vertices"_a, "elements"_a, "(vertices, elements) with nodes between the corners.");
  m.def(
      "element_volumes",
      [](nb::handle x, nb::handle e) { return to_numpy(compute_element_volumes(solid_mesh(x, e))); },
      "vertices"_a, "elements"_a, "Volume of each element [m^3].");
  m.def(
      "solid_boundary_triangles",
      [](nb::handle e) { return to_numpy(find_boundary_triangles(elements_alone(e))); }, "elements"_a,
      "Triangles (k, 3) of the faces of one element only, outwards.");
  m.def(
      "element_name",
      [](nb::handle e) { return std::string(reference_element(elements_alone(e).type).name); }, "elements"_a,
      "Name of the element type that the number of columns stands for.");
}
