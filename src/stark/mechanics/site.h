// A site is a material point or direction and how it moves with the unknowns. Energies are functions of
// sites; only the kinematic map knows that bodies exist.
#pragma once

#include <array>
#include <cstdint>
#include <span>
#include <vector>

#include <stark/base/math.h>

namespace stark {

enum class SiteKind : uint8_t {
  Point,           ///< x = point[index]
  RigidPoint,      ///< x = t + R local
  RigidDirection,  ///< x = R local
  Barycentric,     ///< x = sum_k weight_k point[point_k]
  Embedded,        ///< the same with any number of points, those of row `index` of EmbeddedPoints
  World,           ///< x = local, at rest
};

struct Site {
  SiteKind kind = SiteKind::Point;
  int32_t index = 0;  ///< point, body or row
  Vec3 local{};       ///< lever [m] or direction in the body frame, position in the world [m]
  std::array<int32_t, 4> points{0, 0, 0, 0};  ///< Barycentric only
  std::array<double, 4> weights{0, 0, 0, 0};  ///< Barycentric only; sum to one
};

/// What embedded sites follow: rows of weights of the points of a support, of which many rows may share one,
/// as those of the vertices in a cell of a lattice do.
struct EmbeddedPoints {
  std::vector<int32_t> first_point{0};   ///< [support_count() + 1] into points
  std::vector<int32_t> points;           ///< support by support, no point twice in one
  std::vector<int32_t> support;          ///< by row
  std::vector<int64_t> first_weight{0};  ///< [row_count() + 1] into weights
  std::vector<double> weights;           ///< row by row, sum to one in each

  int32_t support_count() const { return static_cast<int32_t>(first_point.size()) - 1; }
  int32_t row_count() const { return static_cast<int32_t>(support.size()); }
  std::span<const int32_t> points_of(int32_t s) const {
    return {points.data() + first_point[s], static_cast<size_t>(first_point[s + 1] - first_point[s])};
  }
  std::span<const double> weights_of(int32_t row) const {
    return {weights.data() + first_weight[row],
            static_cast<size_t>(first_weight[row + 1] - first_weight[row])};
  }
  int32_t add_support(std::span<const int32_t> of) {
    points.insert(points.end(), of.begin(), of.end());
    first_point.push_back(static_cast<int32_t>(points.size()));
    return support_count() - 1;
  }
  int32_t add_row(int32_t s, std::span<const double> of) {
    support.push_back(s);
    weights.insert(weights.end(), of.begin(), of.end());
    first_weight.push_back(static_cast<int64_t>(weights.size()));
    return row_count() - 1;
  }
};

}  // namespace stark
