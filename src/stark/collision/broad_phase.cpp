// Pairs of cells from the hierarchies become pairs of primitives, sorted. See broad_phase.h.
#include <stark/collision/broad_phase.h>

#include <algorithm>
#include <string>

#include <stark/base/error.h>
#include <stark/collision/bvh.h>

namespace stark {

namespace {

using detail::Box;
using detail::Bvh;
using detail::Cell;
using detail::MovingBox;

using Pairs = std::vector<PrimitivePair>;

// Pairs found by one thread; their union does not depend on the threads and is sorted at the end.
struct alignas(64) PairBuffer {
  CandidateList found;
};

bool has_vertex(const Cell& cell, int32_t v) {
  return (cell.vertices[0] == v) | (cell.vertices[1] == v) | (cell.vertices[2] == v);
}

// Owned points of `a` against the triangle of `b`.
template <typename Extent>
void add_point_triangle(const Bvh& bvh, const Cell& a, const Cell& b, Pairs& out) {
  if (a.point_count == 0) return;
  const Extent box = bvh.cell_extent<Extent>(b);
  for (int k = 0; k < a.point_count; ++k) {
    const int32_t v = a.points[k];
    if (!has_vertex(b, v) && bvh.vertex_extent<Extent>(v).overlaps(box)) out.push_back({v, b.triangle});
  }
}

template <typename Extent>
void add_edge_edge(const Bvh& bvh, const Cell& a, const Cell& b, Pairs& out) {
  for (int i = 0; i < a.edge_count; ++i) {
    const Index2& ea = a.edge_vertices[i];
    const Extent box = bvh.edge_extent<Extent>(ea);
    for (int j = 0; j < b.edge_count; ++j) {
      const Index2& eb = b.edge_vertices[j];
      if ((ea[0] == eb[0]) | (ea[0] == eb[1]) | (ea[1] == eb[0]) | (ea[1] == eb[1])) continue;
      if (!box.overlaps(bvh.edge_extent<Extent>(eb))) continue;
      out.push_back({std::min(a.edges[i], b.edges[j]), std::max(a.edges[i], b.edges[j])});
    }
  }
}

// Owned points of `a` against the edge without triangles of `b`.
template <typename Extent>
void add_point_edge(const Bvh& bvh, const Cell& a, const Cell& b, Pairs& out) {
  if (a.point_count == 0) return;
  const Extent box = bvh.cell_extent<Extent>(b);
  for (int k = 0; k < a.point_count; ++k) {
    const int32_t v = a.points[k];
    if (!has_vertex(b, v) && bvh.vertex_extent<Extent>(v).overlaps(box)) out.push_back({v, b.edges[0]});
  }
}

// Pairs that involve a cell that is a lone point.
template <typename Extent>
void add_lone_point(const Bvh& bvh, const Cell& point, const Cell& other, CandidateList& out) {
  const int32_t v = point.points[0];
  if (has_vertex(other, v)) return;
  if (other.triangle >= 0) {
    add_point_triangle<Extent>(bvh, point, other, out[PairKind::PointTriangle]);
  } else if (!other.is_point()) {
    add_point_edge<Extent>(bvh, point, other, out[PairKind::PointEdge]);
  } else {
    out[PairKind::PointPoint].push_back({std::min(v, other.points[0]), std::max(v, other.points[0])});
  }
}

// Sorts pairs of equal first id by the second; mostly a handful.
void sort_bucket(PrimitivePair* begin, PrimitivePair* end) {
  constexpr int64_t kInsertionLimit = 24;
  if (end - begin > kInsertionLimit) {
    std::sort(begin, end);
    return;
  }
  for (PrimitivePair* i = begin + 1; i < end; ++i) {
    const PrimitivePair value = *i;
    PrimitivePair* hole = i;
    for (; hole > begin && hole[-1].second > value.second; --hole) *hole = hole[-1];
    *hole = value;
  }
}

// Counting first ids, which are read in a row, is faster than sorting pairs up to so many ids for each pair.
constexpr size_t kIdsPerPair = 64;

// Moves the pairs of one kind from all buffers to `out`, sorted by both ids: a counting sort by the first id
// when there are many pairs, then small sorts by the second.
void merge_sorted(const std::vector<PairBuffer>& buffers, PairKind kind, int32_t id_count,
                  std::vector<int32_t>& offsets, Pairs& out) {
  size_t count = 0;
  for (const PairBuffer& buffer : buffers) count += buffer.found[kind].size();
  out.resize(count);
  if (count == 0) return;
  if (count < static_cast<size_t>(id_count) / kIdsPerPair) {
    size_t next = 0;
    for (const PairBuffer& buffer : buffers) {
      for (const PrimitivePair& pair : buffer.found[kind]) out[next++] = pair;
    }
    std::sort(out.begin(), out.end());
    return;
  }
  offsets.assign(static_cast<size_t>(id_count) + 1, 0);
  for (const PairBuffer& buffer : buffers) {
    for (const PrimitivePair& pair : buffer.found[kind]) ++offsets[pair.first + 1];
  }
  for (int32_t id = 0; id < id_count; ++id) offsets[id + 1] += offsets[id];
  for (const PairBuffer& buffer : buffers) {
    for (const PrimitivePair& pair : buffer.found[kind]) out[offsets[pair.first]++] = pair;
  }
  // offsets[id] is now the end of the pairs of id.
  for (int32_t id = 0, begin = 0; id < id_count; begin = offsets[id++]) {
    if (offsets[id] - begin > 1) sort_bucket(out.data() + begin, out.data() + offsets[id]);
  }
}

int32_t primitive_count(const SurfaceMesh& mesh, PrimitiveKind kind) {
  return static_cast<int32_t>(groups_of(mesh, kind).size());
}

/// Drops the pairs that the filter excludes by vertex.
void remove_excluded(const SurfaceMesh& mesh, const PairFilter& filter, CandidateList& list) {
  for_each_pair_kind([&](auto tag) {
    using Row = PairRow<tag.value>;
    std::erase_if(list[tag], [&](const PrimitivePair& pair) {
      const PrimitivePair groups = Row::groups(mesh, pair);
      return filter.excluded(vertices_of<Row::kFirst>(mesh, pair.first), groups.first,
                             vertices_of<Row::kSecond>(mesh, pair.second), groups.second);
    });
  });
}

/// Drops the pairs of a rod that are near along it.
void remove_neighbours(const SurfaceMesh& mesh, const PairFilter& filter, CandidateList& list) {
  std::erase_if(list[PairKind::PointEdge], [&](const PrimitivePair& pair) {
    return filter.are_neighbours(pair.first, mesh.edges[pair.second]);
  });
  std::erase_if(list[PairKind::EdgeEdge], [&](const PrimitivePair& pair) {
    return filter.are_neighbours(mesh.edges[pair.first], mesh.edges[pair.second]);
  });
}

/// Drops the pairs of which no vertex has moved: cells at the border of what has.
void remove_still(const SurfaceMesh& mesh, std::span<const uint8_t> moved, CandidateList& list) {
  for_each_pair_kind([&](auto tag) {
    std::erase_if(list[tag], [&](const PrimitivePair& pair) {
      return std::ranges::none_of(PairRow<tag.value>::vertices(mesh, pair),
                                  [&](int32_t v) { return moved[v] != 0; });
    });
  });
}

}  // namespace

struct BroadPhase::Implementation {
  Bvh bvh;
  PairFilter filter;
  std::vector<PairBuffer> buffers;  // one per thread
  std::vector<int32_t> offsets[2];  // by first primitive of a pair: points, edges

  // All pairs of the boxes that the hierarchies were refitted to.
  template <typename Extent>
  void collect(ThreadPool& pool, CandidateList& out);
};

BroadPhase::BroadPhase() : implementation_(std::make_unique<Implementation>()) {}
BroadPhase::BroadPhase(BroadPhase&&) noexcept = default;
BroadPhase& BroadPhase::operator=(BroadPhase&&) noexcept = default;
BroadPhase::~BroadPhase() = default;

void BroadPhase::reset(SurfaceMesh mesh, PairFilter filter) {
  implementation_->bvh.reset(std::move(mesh), filter.group_count());
  implementation_->filter = std::move(filter);
}

const SurfaceMesh& BroadPhase::mesh() const { return implementation_->bvh.mesh(); }
const PairFilter& BroadPhase::filter() const { return implementation_->filter; }

void BroadPhase::set_filter(PairFilter filter) {
  if (filter.group_count() != implementation_->bvh.group_count()) {
    throw InvalidArgument("BroadPhase: the filter has " + std::to_string(filter.group_count()) +
                          " groups, the mesh has " + std::to_string(implementation_->bvh.group_count()) +
                          "; they must agree");
  }
  implementation_->filter = std::move(filter);
}

void BroadPhase::find(std::span<const Vec3> x, std::span<const double> group_inflation, ThreadPool& pool,
                      CandidateList& out, std::span<const uint8_t> moved) {
  implementation_->bvh.refit(x, group_inflation, pool, moved);
  implementation_->collect<Box>(pool, out);
  implementation_->bvh.learn_clearances(pool);
  if (!moved.empty()) remove_still(mesh(), moved, out);
}

void BroadPhase::find_swept(std::span<const Vec3> x0, std::span<const Vec3> x1,
                            std::span<const double> group_inflation, ThreadPool& pool, CandidateList& out,
                            std::span<const uint8_t> moved) {
  implementation_->bvh.refit(x0, x1, group_inflation, pool, moved);
  implementation_->collect<MovingBox>(pool, out);
  if (!moved.empty()) remove_still(mesh(), moved, out);
}

template <typename Extent>
void BroadPhase::Implementation::collect(ThreadPool& pool, CandidateList& out) {
  buffers.resize(pool.thread_count());
  for (PairBuffer& buffer : buffers) buffer.found.clear();
  bvh.for_each_pair<Extent>(filter, pool, [&](int thread, const Cell& a, const Cell& b, bool) {
    CandidateList& found = buffers[thread].found;
    if (a.is_point()) {
      add_lone_point<Extent>(bvh, a, b, found);
      return;
    }
    if (b.is_point()) {
      add_lone_point<Extent>(bvh, b, a, found);
      return;
    }
    if (b.triangle >= 0)
      add_point_triangle<Extent>(bvh, a, b, found[PairKind::PointTriangle]);
    else
      add_point_edge<Extent>(bvh, a, b, found[PairKind::PointEdge]);
    if (a.triangle >= 0)
      add_point_triangle<Extent>(bvh, b, a, found[PairKind::PointTriangle]);
    else
      add_point_edge<Extent>(bvh, b, a, found[PairKind::PointEdge]);
    add_edge_edge<Extent>(bvh, a, b, found[PairKind::EdgeEdge]);
  });
  const SurfaceMesh& mesh = bvh.mesh();
  const auto merge_lists = [&](int64_t first, int) {
    for_each_pair_kind([&](auto tag) {
      if (static_cast<int64_t>(first_kind(tag)) != first) return;
      merge_sorted(buffers, tag, primitive_count(mesh, first_kind(tag)), offsets[first], out[tag]);
    });
  };
  size_t found_edges = 0;
  for (const PairBuffer& buffer : buffers) found_edges += buffer.found[PairKind::EdgeEdge].size();
  constexpr size_t kParallelMerge = 10000;  // fewer are sorted before the other threads wake up
  if (found_edges > kParallelMerge) {
    pool.for_each_task(2, merge_lists);
  } else {
    merge_lists(0, 0);
    merge_lists(1, 0);
  }
  if (filter.has_exclusions()) remove_excluded(mesh, filter, out);
  if (filter.has_neighbours()) remove_neighbours(mesh, filter, out);
}

}  // namespace stark
