// A small scene of every kind of site: free and prescribed points, two free rigid bodies, a prescribed one,
// directions and barycentric sites, joined by simple energies of one to four points. For tests of maps and
// assembly.
#pragma once

#include <memory>
#include <vector>

#include <stark/base/rotation.h>
#include <stark/mechanics/assembler.h>
#include <stark/mechanics/define.h>
#include <support/random_points.h>

namespace stark::test {

/// 1/2 k (|x1 - x0| - L)^2.
inline PotentialDefinition spring() {
  return define_potential("spring", 2, "spring", [](PotentialBuilder& b) {
    const auto stretch = symbolic::norm(b.x(1) - b.x(0)) - b.data("length", "m", "rest length");
    return 0.5 * b.parameter("stiffness", "N/m", "stiffness") * symbolic::square(stretch);
  });
}

/// |x - c|^4 of one point: not quadratic and not invariant.
inline PotentialDefinition well() {
  PotentialDefinition definition = define_potential("well", 1, "quartic well", [](PotentialBuilder& b) {
    const auto distance = symbolic::squared_norm(b.x(0) - b.data3("centre", "m", "centre"));
    return symbolic::square(distance);
  });
  definition.translation_invariant = definition.rotation_invariant = false;
  return definition;
}

/// Squared area of three points.
inline PotentialDefinition area() {
  return define_potential("area", 3, "squared area", [](PotentialBuilder& b) {
    return 0.5 * symbolic::squared_norm(symbolic::cross(b.x(1) - b.x(0), b.x(2) - b.x(0)));
  });
}

/// Squared volume of four points: indefinite Hessian, all pairs coupled.
inline PotentialDefinition volume() {
  return define_potential("volume", 4, "squared volume", [](PotentialBuilder& b) {
    const auto v = symbolic::dot(b.x(1) - b.x(0), symbolic::cross(b.x(2) - b.x(0), b.x(3) - b.x(0)));
    return symbolic::square(v + 0.3) +
           0.1 * symbolic::square(symbolic::dot(b.x(0) - b.x(3), b.x(1) - b.x(2)));
  });
}

inline PotentialBatch make_batch(const PotentialDefinition& definition,
                                 const std::vector<int32_t>& stencils) {
  PotentialBatch batch(std::make_shared<Potential>(definition, symbolic::Backend::Automatic));
  batch.resize(stencils);
  return batch;
}

class MixedScene {
 public:
  // Points 0..4 are free, 5 and 6 prescribed; bodies 0 and 1 are free, 2 is prescribed.
  static constexpr int kFreePoints = 5, kPoints = 7, kBodies = 3;

  explicit MixedScene(unsigned seed) {
    RandomPoints random(seed);
    for (int p = 0; p < kPoints; ++p) configuration.point_position.push_back(random.point());
    for (int b = 0; b < kBodies; ++b) {
      configuration.body_position.push_back(random.point());
      configuration.body_rotation.push_back(exp_rotation(random.point() * 2.0));
    }
    std::vector<Site> sites;
    for (int p = 0; p < kPoints; ++p)
      sites.push_back({.kind = SiteKind::Point, .index = p, .local = {}, .points = {}, .weights = {}});
    for (int b = 0; b < kBodies; ++b) {
      for (int k = 0; k < 2; ++k)
        sites.push_back(
            {.kind = SiteKind::RigidPoint, .index = b, .local = random.point(), .points = {}, .weights = {}});
      sites.push_back({.kind = SiteKind::RigidDirection,
                       .index = b,
                       .local = random.point(),
                       .points = {},
                       .weights = {}});
    }
    first_barycentric = static_cast<int32_t>(sites.size());
    sites.push_back({.kind = SiteKind::Barycentric,
                     .index = 0,
                     .local = {},
                     .points = {0, 1, 2, 3},
                     .weights = {0.1, 0.2, 0.3, 0.4}});
    sites.push_back({.kind = SiteKind::Barycentric,
                     .index = 0,
                     .local = {},
                     .points = {4, 5, 6, 0},
                     .weights = {0.5, 0.3, 0.2, 0.0}});
    sites.push_back({.kind = SiteKind::Barycentric,
                     .index = 0,
                     .local = {},
                     .points = {5, 6, 5, 6},
                     .weights = {0.4, 0.6, 0.0, 0.0}});
    EmbeddedPoints embedded;
    for (const auto& points : {std::array{0, 1, 2, 3, 4}, std::array{5, 2, 6, 0, 1}})
      embedded.add_support(points);
    for (const int32_t support : {0, 1, 0})
      sites.push_back(
          {.kind = SiteKind::Embedded,
           .index = embedded.add_row(support, std::array{0.3, 0.1 + 0.1 * support, 0.25, -0.1, 0.45}),
           .local = {},
           .points = {},
           .weights = {}});
    map =
        KinematicMap(DofLayout::build({false, false, false, false, false, true, true}, {false, false, true}),
                     sites, embedded);

    // Every potential on stencils of many combinations of sites; elements may meet a body or a point twice.
    const auto stencils = [&](int count, int points) {
      std::vector<int32_t> result;
      for (int e = 0; e < count; ++e)
        for (int p = 0; p < points; ++p) {
          int32_t site = random.integer(0, map.site_count() - 1);
          const auto repeated = [&] {
            for (int q = 1; q <= p; ++q)
              if (result[result.size() - q] == site) return true;
            return false;
          };
          while (repeated()) site = random.integer(0, map.site_count() - 1);
          result.push_back(site);
        }
      return result;
    };
    batches.push_back(make_batch(spring(), stencils(40, 2)));
    batches.back().set_uniform("stiffness", 2.0);
    for (int64_t e = 0; e < batches.back().size(); ++e)
      batches.back().set("length", e, random.uniform(0.5, 1.5));
    batches.push_back(make_batch(well(), stencils(13, 1)));
    for (int64_t e = 0; e < batches.back().size(); ++e) {
      const Vec3 c = random.point();
      batches.back().set(batches.back().field_index("centre"), e, {&c.x, 3});
    }
    batches.push_back(make_batch(area(), stencils(21, 3)));
    batches.push_back(make_batch(volume(), stencils(33, 4)));
    // Points alone: the path of the assembler without maps.
    batches.push_back(make_batch(volume(), {0, 1, 2, 3, 1, 2, 3, 4, 5, 0, 6, 1, 4, 3, 5, 0}));
  }

  std::vector<Vec3> positions(const Configuration& c) const {
    std::vector<Vec3> x(map.site_count());
    map.positions(c, x);
    return x;
  }

  /// Sum of all element energies, evaluated one by one.
  double energy(std::span<const Vec3> x) const {
    double sum = 0.0;
    for (const PotentialBatch& batch : batches) {
      AlignedVector<double> out(batch.block_count() * symbolic::kLanes);
      batch.evaluate(symbolic::Order::Energy, x, 0, batch.block_count(), out.data());
      for (int64_t e = 0; e < batch.size(); ++e) sum += out[e];
    }
    return sum;
  }
  double energy(const Configuration& c) const { return energy(positions(c)); }

  std::vector<const PotentialBatch*> pointers(size_t first, size_t last) const {
    std::vector<const PotentialBatch*> result;
    for (size_t k = first; k < last; ++k) result.push_back(&batches[k]);
    return result;
  }

  /// Static batches, which the assembler touches.
  std::vector<PotentialBatch*> fixed(size_t first, size_t last) const {
    std::vector<PotentialBatch*> result;
    for (size_t k = first; k < last; ++k) result.push_back(&batches[k]);
    return result;
  }

  /// configuration moved along direction by t.
  Configuration along(std::span<const double> direction, double t) const {
    Configuration result;
    map.retract(configuration, direction, t, KinematicMap::Way::Straight, result);
    return result;
  }

  int dof_count() const { return 3 * map.layout().block_count; }

  KinematicMap map;
  Configuration configuration;
  mutable std::vector<PotentialBatch> batches;
  int32_t first_barycentric = 0;
};

/// Gradient and dense Hessian of a block matrix.
struct Assembled {
  std::vector<double> gradient, hessian;  ///< [n], [n][n]
  BlockMatrix matrix;
};

inline std::vector<double> to_dense(const BlockMatrix& matrix) {
  const int n = 3 * matrix.pattern.block_count;
  std::vector<double> dense(static_cast<size_t>(n) * n);
  for (int32_t i = 0; i < matrix.pattern.block_count; ++i)
    for (int64_t s = matrix.pattern.row_start[i]; s < matrix.pattern.row_start[i + 1]; ++s)
      for (int r = 0; r < 3; ++r)
        for (int c = 0; c < 3; ++c) {
          const int row = 3 * i + r, column = 3 * matrix.pattern.column[s] + c;
          dense[row * n + column] = dense[column * n + row] = matrix.values[9 * s + 3 * r + c];
        }
  return dense;
}

}  // namespace stark::test
