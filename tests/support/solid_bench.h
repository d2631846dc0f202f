// Solid meshes of every element type as batches with quadrature points, and their assembly.
#pragma once

#include <memory>
#include <random>
#include <vector>

#include <stark/geometry/shapes.h>
#include <stark/geometry/solid_mesh.h>
#include <stark/mechanics/assembler.h>
#include <stark/mechanics/constitutive_law.h>
#include <support/random_points.h>

namespace stark::test {

/// G/2 |C - 1|^2/4 + K/2 (J - 1)^2: polynomial, indefinite in compression.
inline SolidLaw test_law() {
  return define_solid_law("test", "", [](PotentialBuilder& b, const SolidDeformation& deformation) {
    const auto F = deformation.F();
    const auto E = transpose(F) * F - symbolic::Mat3::identity();
    return b.parameter("shear_modulus", "Pa", "") * 0.125 * squared_norm(E) +
           0.5 * b.parameter("bulk_modulus", "Pa", "") * symbolic::square(determinant(F) - 1.0);
  });
}

/// `definition`: of quadrature_point() or of mean_dilatation_point().
inline QuadratureBatch make_quadrature_batch(const SolidMesh& mesh, const PotentialDefinition& definition,
                                             const ParameterValues& values) {
  const auto& rule = reference_element(mesh.type).quadrature;
  const int points = static_cast<int>(rule.size());
  const auto law =
      std::make_shared<Potential>(definition, symbolic::Backend::Automatic, per_element_names(values));
  const auto ratio = std::make_shared<Potential>(volume_ratio(), symbolic::Backend::Automatic);
  QuadratureBatch batch = definition.point_count == 3
                              ? QuadratureBatch(law, mesh.node_count(), points)
                              : QuadratureBatch(law, mesh.node_count(), points,
                                                {ratio, points, mean_dilatation_modes(mesh.type)});
  batch.resize(mesh.elements);
  std::vector<Vec3> gradients(rule.size() * mesh.node_count());
  std::vector<double> weights(rule.size());
  std::vector<Vec3> positions(rule.size());
  for (int64_t e = 0; e < mesh.element_count(); ++e) {
    for (size_t q = 0; q < rule.size(); ++q) {
      weights[q] = rule[q].weight *
                   rest_gradients(mesh, e, rule[q].position,
                                  std::span(gradients).subspan(q * mesh.node_count(), mesh.node_count()));
      positions[q] = rest_position(mesh, e, rule[q].position);
    }
    batch.set_geometry(e, gradients, weights, positions);
  }
  batch.set_values(values);
  return batch;
}

/// Box meshes of the four element types, with nodes off their regular places.
inline std::vector<SolidMesh> distorted_boxes(const Index3& cells = {2, 1, 2}, double distortion = 0.03) {
  const SolidMesh tets = make_tet_box({1, 1, 1}, cells), hexes = make_hex_box({1, 1, 1}, cells);
  std::vector<SolidMesh> meshes{tets, to_quadratic(tets), hexes, to_quadratic(hexes)};
  RandomPoints random(9);
  for (SolidMesh& mesh : meshes)
    for (Vec3& v : mesh.vertices) v += random.point() * distortion;
  return meshes;
}

/// Unknowns of all vertices but the prescribed ones.
inline KinematicMap point_map(size_t count, const std::vector<int32_t>& prescribed = {}) {
  std::vector<bool> is_prescribed(count, false);
  for (const int32_t p : prescribed) is_prescribed[p] = true;
  std::vector<Site> sites;
  for (size_t i = 0; i < count; ++i)
    sites.push_back({.kind = SiteKind::Point,
                     .index = static_cast<int32_t>(i),
                     .local = {},
                     .points = {},
                     .weights = {}});
  return KinematicMap(DofLayout::build(is_prescribed, {}), std::move(sites));
}

/// Dense copy of the assembled system.
struct DenseSystem {
  std::vector<double> gradient, hessian;  ///< [n], [n][n]
};

inline DenseSystem assemble_dense(Assembler& assembler, const KinematicMap& map, const std::vector<Vec3>& x,
                                  const AssemblyOptions& options = {}) {
  const int n = 3 * map.layout().block_count;
  DenseSystem system{std::vector<double>(n), std::vector<double>(static_cast<size_t>(n) * n)};
  BlockMatrix H;
  assembler.assemble({}, x, options, system.gradient, H);
  for (int32_t i = 0; i < H.pattern.block_count; ++i)
    for (int64_t s = H.pattern.row_start[i]; s < H.pattern.row_start[i + 1]; ++s)
      for (int r = 0; r < 3; ++r)
        for (int c = 0; c < 3; ++c) {
          const int row = 3 * i + r, column = 3 * H.pattern.column[s] + c;
          system.hessian[static_cast<size_t>(row) * n + column] = H.values[9 * s + 3 * r + c];
          system.hessian[static_cast<size_t>(column) * n + row] = H.values[9 * s + 3 * r + c];
        }
  return system;
}

}  // namespace stark::test
