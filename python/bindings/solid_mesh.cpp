// Bindings of solid meshes of all element types: generation, refinement by order, boundary, volumes.
#include "solid_mesh.h"

#include <stark/geometry/embedding.h>
#include <stark/geometry/lattice.h>

#include "with_arrays.h"
#include "without_gil.h"

namespace stark::bindings {

namespace {

/// Mesh with indices in range.
SolidMesh solid_mesh(nb::handle vertices, nb::handle elements) {
  SolidMesh mesh;
  mesh.vertices = read<std::vector<Vec3>>(vertices, "vertices", "an (n, 3) array of positions [m]");
  read_elements(elements, "elements", mesh);
  check_indices(mesh);
  return mesh;
}

nb::tuple lattice(const std::vector<Vec3>& vertices, const std::vector<Index3>& triangles, double cell_size,
                  bool quadratic) {
  SolidMesh mesh = without_gil([&] { return make_lattice({vertices, triangles}, cell_size, quadratic); });
  const Embedding embedding = std::move(mesh.embedding);
  return nb::make_tuple(mesh, ArrayOf{embedding.elements}, ArrayOf{embedding.triangles},
                        ArrayOf{embedding.fillings});
}

nb::object weights_of(nb::handle vertices, nb::handle elements, const nb::dict& embedding) {
  SolidMesh mesh = solid_mesh(vertices, elements);
  mesh.embedding = embedding_of(embedding, "embedding_weights");
  const size_t nodes = mesh.node_count(), count = mesh.embedding.elements.size();
  std::vector<double> weights(count * nodes);
  for (size_t k = 0; k < count; ++k) embedding_weights(mesh, k, std::span(weights).subspan(k * nodes, nodes));
  return nb::cast(to_numpy(std::move(weights), {count, nodes}));
}

std::vector<double> filled_volumes(nb::handle vertices, nb::handle elements, const nb::dict& embedding) {
  SolidMesh mesh = solid_mesh(vertices, elements);
  mesh.embedding = embedding_of(embedding, "filled_volumes");
  if (mesh.embedding.fillings.size() != static_cast<size_t>(mesh.element_count()))
    throw InvalidMesh("filled_volumes: filling: must have a row for each element");
  return compute_element_volumes(mesh);
}

/// A mesh of elements without vertices.
SolidMesh elements_alone(nb::handle elements) {
  SolidMesh mesh;
  read_elements(elements, "elements", mesh);
  return mesh;
}

}  // namespace

void bind_solid_mesh(nb::module_& m) {
  m.def("make_hex_box", &make_hex_box, "size"_a, "cells"_a,
        "(vertices, elements) of a box of hexahedra with 8 nodes.");
  m.def("make_lattice",
        with_arrays<lattice, "vertices: an (n, 3) array of positions [m]",
                    "triangles: an (m, 3) array of vertices">,
        "vertices"_a, "triangles"_a, "cell_size"_a, "quadratic"_a,
        "((vertices, elements), cells, triangles, filling) of a surface in a lattice of cubes.");
  m.def("filled_volumes", with_arrays<filled_volumes>, "vertices"_a, "elements"_a, "embedding"_a,
        "Volume of what is filled of each element [m^3].");
  m.def("embedding_weights", weights_of, "vertices"_a, "elements"_a, "embedding"_a,
        "Shape functions of its element at each embedded vertex.");
  m.def(
      "to_quadratic", [](nb::handle x, nb::handle e) { return to_quadratic(solid_mesh(x, e)); }, "vertices"_a,
      "elements"_a, "(vertices, elements) with nodes between the corners.");
  m.def(
      "element_volumes",
      [](nb::handle x, nb::handle e) { return ArrayOf{compute_element_volumes(solid_mesh(x, e))}; },
      "vertices"_a, "elements"_a, "Volume of each element [m^3].");
  m.def(
      "solid_boundary_triangles",
      [](nb::handle e) { return ArrayOf{find_boundary_triangles(elements_alone(e))}; }, "elements"_a,
      "Triangles (k, 3) of the faces of one element only, outwards.");
  m.def(
      "element_name",
      [](nb::handle e) { return std::string(reference_element(elements_alone(e).type).name); }, "elements"_a,
      "Name of the element type that the number of columns stands for.");
}

}  // namespace stark::bindings
