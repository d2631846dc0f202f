// The table of kinds of pairs of primitives that collision detection and contact look at: one row each. A row
// names the two primitives, their distance and their continuous collision detection; candidate lists, boxes,
// filters, step bounds, contacts and friction derive from it. A new kind adds its row here, where the broad
// phase finds it (broad_phase.cpp) and which barrier it has (contact/contact_set.cpp).
#pragma once

#include <array>
#include <compare>
#include <cstdint>
#include <span>
#include <string_view>
#include <type_traits>
#include <vector>

#include <stark/collision/ccd.h>
#include <stark/collision/surface_mesh.h>
#include <stark/geometry/distance.h>

namespace stark {

enum class PrimitiveKind : uint8_t { Point, Edge, Triangle };

/// In the order of the rows below; the numbers are written to checkpoints. The last two are what the first
/// two cannot see: points against edges without triangles, because pairs of edges that are parallel have no
/// barrier, and points without edges against each other.
enum class PairKind : uint8_t { PointTriangle, EdgeEdge, PointEdge, PointPoint };
inline constexpr int kPairKindCount = 4;

/// Ids of two primitives; of two of the same kind the lower one comes first.
struct PrimitivePair {
  int32_t first = 0, second = 0;
  auto operator<=>(const PrimitivePair&) const = default;
};

template <PrimitiveKind kind>
auto vertices_of(const SurfaceMesh& mesh, int32_t id) {
  if constexpr (kind == PrimitiveKind::Point) return std::array{id};
  if constexpr (kind == PrimitiveKind::Edge) return mesh.edges[id];
  if constexpr (kind == PrimitiveKind::Triangle) return mesh.triangles[id];
}

/// Group of each primitive of a kind.
inline const std::vector<int32_t>& groups_of(const SurfaceMesh& mesh, PrimitiveKind kind) {
  return kind == PrimitiveKind::Point  ? mesh.vertex_group
         : kind == PrimitiveKind::Edge ? mesh.edge_group
                                       : mesh.triangle_group;
}

/// What all rows have: `first` and `second` are the primitives.
template <PrimitiveKind first, PrimitiveKind second>
struct PairOf {
  static constexpr PrimitiveKind kFirst = first, kSecond = second;
  static constexpr int kFirstCount = 1 + static_cast<int>(first), kSecondCount = 1 + static_cast<int>(second);
  using Vertices = std::array<int32_t, kFirstCount + kSecondCount>;
  using Positions = std::array<Vec3, kFirstCount + kSecondCount>;

  /// Those of the first primitive, then those of the second.
  static Vertices vertices(const SurfaceMesh& mesh, const PrimitivePair& pair) {
    Vertices all;
    const auto a = vertices_of<first>(mesh, pair.first);
    const auto b = vertices_of<second>(mesh, pair.second);
    for (int i = 0; i < kFirstCount; ++i) all[i] = a[i];
    for (int i = 0; i < kSecondCount; ++i) all[kFirstCount + i] = b[i];
    return all;
  }
  static Positions positions(const SurfaceMesh& mesh, const PrimitivePair& pair, std::span<const Vec3> x) {
    const Vertices ids = vertices(mesh, pair);
    Positions p;
    for (size_t i = 0; i < ids.size(); ++i) p[i] = x[ids[i]];
    return p;
  }
  static PrimitivePair groups(const SurfaceMesh& mesh, const PrimitivePair& pair) {
    return {groups_of(mesh, first)[pair.first], groups_of(mesh, second)[pair.second]};
  }
};

template <PairKind kind>
struct PairRow;

template <>
struct PairRow<PairKind::PointTriangle> : PairOf<PrimitiveKind::Point, PrimitiveKind::Triangle> {
  static constexpr std::string_view kName = "point_triangle";
  static constexpr auto kCcd = point_triangle_ccd;
  static double squared_distance(const Positions& x) {
    return point_triangle_squared_distance(x[0], x[1], x[2], x[3]);
  }
};

template <>
struct PairRow<PairKind::EdgeEdge> : PairOf<PrimitiveKind::Edge, PrimitiveKind::Edge> {
  static constexpr std::string_view kName = "edge_edge";
  static constexpr auto kCcd = edge_edge_ccd;
  static double squared_distance(const Positions& x) {
    return edge_edge_squared_distance(x[0], x[1], x[2], x[3]);
  }
};

template <>
struct PairRow<PairKind::PointEdge> : PairOf<PrimitiveKind::Point, PrimitiveKind::Edge> {
  static constexpr std::string_view kName = "point_edge";
  static constexpr auto kCcd = point_edge_ccd;
  static double squared_distance(const Positions& x) { return point_edge_squared_distance(x[0], x[1], x[2]); }
};

template <>
struct PairRow<PairKind::PointPoint> : PairOf<PrimitiveKind::Point, PrimitiveKind::Point> {
  static constexpr std::string_view kName = "point_point";
  static constexpr auto kCcd = point_point_ccd;
  static double squared_distance(const Positions& x) { return point_point_squared_distance(x[0], x[1]); }
};

/// A kind as a type: what functions for one row are told apart by.
template <PairKind kind>
using PairTag = std::integral_constant<PairKind, kind>;

/// Calls f with the tag of each row, in their order.
template <typename Function>
void for_each_pair_kind(Function&& f) {
  f(PairTag<PairKind::PointTriangle>{});
  f(PairTag<PairKind::EdgeEdge>{});
  f(PairTag<PairKind::PointEdge>{});
  f(PairTag<PairKind::PointPoint>{});
}

/// Calls f with the tag of one kind and returns what it returns.
template <typename Function>
auto with_pair_kind(PairKind kind, Function&& f) {
  switch (kind) {
    case PairKind::PointTriangle:
      return f(PairTag<PairKind::PointTriangle>{});
    case PairKind::EdgeEdge:
      return f(PairTag<PairKind::EdgeEdge>{});
    case PairKind::PointEdge:
      return f(PairTag<PairKind::PointEdge>{});
    case PairKind::PointPoint:
      break;
  }
  return f(PairTag<PairKind::PointPoint>{});
}

inline PrimitiveKind first_kind(PairKind kind) {
  return with_pair_kind(kind, [](auto tag) { return PairRow<tag.value>::kFirst; });
}
inline PrimitiveKind second_kind(PairKind kind) {
  return with_pair_kind(kind, [](auto tag) { return PairRow<tag.value>::kSecond; });
}
inline std::string_view to_string(PairKind kind) {
  return with_pair_kind(kind, [](auto tag) { return PairRow<tag.value>::kName; });
}

/// Vertices of one primitive; `id` must outlive the result.
inline std::span<const int32_t> vertices_of(const SurfaceMesh& mesh, PrimitiveKind kind, const int32_t& id) {
  if (kind == PrimitiveKind::Point) return {&id, 1};
  if (kind == PrimitiveKind::Edge) return mesh.edges[id];
  return mesh.triangles[id];
}

/// Squared distance of the primitives of a pair with vertices at x [m^2].
inline double squared_distance(const SurfaceMesh& mesh, PairKind kind, const PrimitivePair& pair,
                               std::span<const Vec3> x) {
  return with_pair_kind(kind, [&](auto tag) {
    using Row = PairRow<tag.value>;
    return Row::squared_distance(Row::positions(mesh, pair, x));
  });
}

}  // namespace stark
