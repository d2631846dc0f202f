// Bindings of solid meshes of all element types: generation, refinement by order, boundary, volumes.
#include "solid_mesh.h"

#include <stark/geometry/embedding.h>
#include <stark/geometry/lattice.h>

#include "without_gil.h"

namespace stark::bindings {

/// Of elements alone where no vertices are given.
template <>
inline constexpr bool comes_as_array<SolidMesh> = true;
template <>
SolidMesh read(nb::handle entries, const std::string& name, const std::string&) {
  const Given given(entries, name);
  SolidMesh mesh = solid_mesh(given);
  if (given.find("vertices")) check_indices(mesh);
  return mesh;
}

namespace {

/// (vertices, elements)
auto arrays_of_mesh(const SolidMesh& mesh) {
  const size_t count = mesh.element_count(), nodes = mesh.node_count();
  return std::pair(to_numpy(mesh.vertices), to_numpy(mesh.elements, {count, nodes}));
}

/// The mesh of a surface in a lattice of cubes, and what its embedding is made of.
auto lattice(const std::vector<Vec3>& vertices, const std::vector<Index3>& triangles, double cell_size,
             bool quadratic) {
  SolidMesh mesh = without_gil([&] { return make_lattice({vertices, triangles}, cell_size, quadratic); });
  const Embedding embedding = std::move(mesh.embedding);
  return std::tuple(arrays_of_mesh(mesh), embedding.elements, embedding.triangles, embedding.fillings);
}

auto hex_box(const Vec3& size, const Index3& cells) { return arrays_of_mesh(make_hex_box(size, cells)); }

auto quadratic(const SolidMesh& mesh) { return arrays_of_mesh(to_quadratic(mesh)); }

/// Shape functions of its element at each embedded vertex.
auto weights_of(const SolidMesh& mesh) {
  const size_t count = mesh.embedding.elements.size(), nodes = mesh.node_count();
  return to_numpy(embedding_weights(mesh), {count, nodes});
}

std::vector<Index3> boundary_triangles(const SolidMesh& mesh) { return find_boundary_triangles(mesh); }

std::string element_name(const SolidMesh& mesh) { return std::string(reference_element(mesh.type).name); }

}  // namespace

void bind_solid_mesh(nb::module_& m) {
  def(m, "make_hex_box", hex_box, {"size", "cells"});
  def(m, "make_lattice", lattice,
      {"vertices: an (n, 3) array of positions [m]", "triangles: an (m, 3) array of vertices", "cell_size",
       "quadratic"});
  def(m, "embedding_weights", weights_of, {"mesh"});
  def(m, "to_quadratic", quadratic, {"mesh"});
  def(m, "element_volumes", compute_element_volumes, {"mesh"}, "Of what is filled of each [m^3].");
  def(m, "solid_boundary_triangles", boundary_triangles, {"mesh"});
  def<element_name>(m, {"mesh"});
}

}  // namespace stark::bindings
