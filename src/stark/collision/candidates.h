// The collision primitives of a scene and the lists of primitive pairs that may touch. Pure data; the broad
// phase fills the lists, continuous detection and contact read them in every iteration.
#pragma once

#include <cstdint>
#include <span>
#include <vector>

#include <stark/geometry/mesh.h>

namespace stark {

/// All collision primitives of a scene; vertex ids index one position array. Every vertex of an edge or
/// triangle is a collision point unless it is `inner`; `points` adds vertices that belong to neither
/// (particles). Vertices inside solids are simply not named.
struct SurfaceMesh {
  int32_t vertex_count = 0;
  std::vector<int32_t> points;  // vertices without edges or triangles; others may be listed, too
  std::vector<int32_t> inner;   // vertices of triangles that are no collision points: inside flat faces
  std::vector<Index2> edges;
  std::vector<Index3> triangles;
  std::vector<int32_t> vertex_group, edge_group, triangle_group;  // collision group (body) of each primitive
};

/// Throws InvalidMesh for indices out of range, array sizes that do not match, repeated vertices, groups
/// outside [0, group_count) and primitives whose vertices are of another group.
void validate(const SurfaceMesh& mesh, int32_t group_count);

struct PointTriangleCandidate {
  int32_t point, triangle;
  bool operator==(const PointTriangleCandidate&) const = default;
};

/// edge_a < edge_b.
struct EdgeEdgeCandidate {
  int32_t edge_a, edge_b;
  bool operator==(const EdgeEdgeCandidate&) const = default;
};

/// A point against an edge without triangles.
struct PointEdgeCandidate {
  int32_t point, edge;
  bool operator==(const PointEdgeCandidate&) const = default;
};

/// Two points without edges, point_a < point_b.
struct PointPointCandidate {
  int32_t point_a, point_b;
  bool operator==(const PointPointCandidate&) const = default;
};

/// Pairs that share no vertex, each once, sorted by first and second id. The last two lists hold what the
/// first two cannot see: points against rods, because pairs of edges that are parallel have no barrier, and
/// particles against particles.
struct CandidateList {
  std::vector<PointTriangleCandidate> point_triangle;
  std::vector<EdgeEdgeCandidate> edge_edge;
  std::vector<PointEdgeCandidate> point_edge;
  std::vector<PointPointCandidate> point_point;

  void clear();
  int64_t size() const;
  bool operator==(const CandidateList&) const = default;
};

/// Which groups may touch: a symmetric table that includes each group with itself. Single vertices may be
/// kept from a group, with every primitive that they are part of.
class PairFilter {
 public:
  PairFilter() = default;
  explicit PairFilter(int32_t group_count, bool allow_pairs = true, bool allow_self = true);

  void set(int32_t group_a, int32_t group_b, bool allowed);
  bool allowed(int32_t group_a, int32_t group_b) const { return table_[index(group_a, group_b)]; }
  int32_t group_count() const { return group_count_; }

  /// Keeps all primitives with this vertex from those of the group.
  void exclude(int32_t vertex, int32_t group);
  bool has_exclusions() const { return !excluded_.empty(); }
  bool excluded(int32_t vertex, int32_t group) const;
  /// Whether some vertex of one primitive is kept from the group of the other.
  bool excluded(std::span<const int32_t> vertices_a, int32_t group_a, std::span<const int32_t> vertices_b,
                int32_t group_b) const;

  /// Keeps a point from the edges without triangles that end at another: parts of a rod that are so near
  /// along it that they are within the contact distance whatever its shape.
  void set_neighbours(int32_t vertex_a, int32_t vertex_b);
  bool has_neighbours() const { return !neighbours_.empty(); }
  bool are_neighbours(int32_t point, const Index2& edge) const;

 private:
  static size_t index(int32_t a, int32_t b) {
    const size_t low = static_cast<size_t>(a < b ? a : b), high = static_cast<size_t>(a < b ? b : a);
    return high * (high + 1) / 2 + low;
  }

  int32_t group_count_ = 0;
  std::vector<bool> table_;
  std::vector<std::vector<int32_t>> excluded_;    ///< groups, by vertex; as long as needed
  std::vector<std::vector<int32_t>> neighbours_;  ///< vertices, by vertex; as long as needed
};

}  // namespace stark
