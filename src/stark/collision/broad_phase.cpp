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

using Pair = std::array<int32_t, 2>;

// Pairs found by one thread; their union does not depend on the threads and is sorted at the end.
struct alignas(64) PairBuffer {
  std::vector<Pair> point_triangle, edge_edge, point_edge, point_point;

  void clear() {
    point_triangle.clear();
    edge_edge.clear();
    point_edge.clear();
    point_point.clear();
  }
};

bool has_vertex(const Cell& cell, int32_t v) {
  return (cell.vertices[0] == v) | (cell.vertices[1] == v) | (cell.vertices[2] == v);
}

// Owned points of `a` against the triangle of `b`.
void add_point_triangle(const Bvh& bvh, const Cell& a, const Cell& b, std::vector<Pair>& out) {
  if (a.point_count == 0) return;
  const Box box = bvh.cell_box(b);
  for (int k = 0; k < a.point_count; ++k) {
    const int32_t v = a.points[k];
    if (!has_vertex(b, v) && bvh.vertex_box(v).overlaps(box)) out.push_back({v, b.triangle});
  }
}

void add_edge_edge(const Bvh& bvh, const Cell& a, const Cell& b, std::vector<Pair>& out) {
  for (int i = 0; i < a.edge_count; ++i) {
    const Index2& ea = a.edge_vertices[i];
    const Box box = bvh.edge_box(ea);
    for (int j = 0; j < b.edge_count; ++j) {
      const Index2& eb = b.edge_vertices[j];
      if ((ea[0] == eb[0]) | (ea[0] == eb[1]) | (ea[1] == eb[0]) | (ea[1] == eb[1])) continue;
      if (!box.overlaps(bvh.edge_box(eb))) continue;
      out.push_back({std::min(a.edges[i], b.edges[j]), std::max(a.edges[i], b.edges[j])});
    }
  }
}

// Owned points of `a` against the edge without triangles of `b`.
void add_point_edge(const Bvh& bvh, const Cell& a, const Cell& b, std::vector<Pair>& out) {
  if (a.point_count == 0) return;
  const Box box = bvh.cell_box(b);
  for (int k = 0; k < a.point_count; ++k) {
    const int32_t v = a.points[k];
    if (!has_vertex(b, v) && bvh.vertex_box(v).overlaps(box)) out.push_back({v, b.edges[0]});
  }
}

// Pairs that involve a cell that is a lone point.
void add_lone_point(const Bvh& bvh, const Cell& point, const Cell& other, PairBuffer& out) {
  const int32_t v = point.points[0];
  if (has_vertex(other, v)) return;
  if (other.triangle >= 0) {
    add_point_triangle(bvh, point, other, out.point_triangle);
  } else if (!other.is_point()) {
    add_point_edge(bvh, point, other, out.point_edge);
  } else {
    out.point_point.push_back({std::min(v, other.points[0]), std::max(v, other.points[0])});
  }
}

template <typename Candidate>
bool less(const Candidate& a, const Candidate& b) {
  const auto& [a0, a1] = a;
  const auto& [b0, b1] = b;
  return a0 != b0 ? a0 < b0 : a1 < b1;
}

// Sorts pairs of equal first id by the second; mostly a handful.
template <typename Candidate>
void sort_bucket(Candidate* begin, Candidate* end) {
  constexpr int64_t kInsertionLimit = 24;
  if (end - begin > kInsertionLimit) {
    std::sort(begin, end, less<Candidate>);
    return;
  }
  const auto second = [](const Candidate& c) {
    const auto& [c0, c1] = c;
    return c1;
  };
  for (Candidate* i = begin + 1; i < end; ++i) {
    const Candidate value = *i;
    Candidate* hole = i;
    for (; hole > begin && second(hole[-1]) > second(value); --hole) *hole = hole[-1];
    *hole = value;
  }
}

// Moves the pairs of all buffers to `out`, sorted by both ids: a counting sort by the first id when there are
// many pairs, then small sorts by the second.
template <typename Candidate>
void merge_sorted(const std::vector<PairBuffer>& buffers, std::vector<Pair> PairBuffer::* member,
                  int32_t id_count, std::vector<int32_t>& offsets, std::vector<Candidate>& out) {
  size_t count = 0;
  for (const PairBuffer& buffer : buffers) count += (buffer.*member).size();
  out.resize(count);
  if (count == 0) return;
  if (count < static_cast<size_t>(id_count) / 8) {
    size_t next = 0;
    for (const PairBuffer& buffer : buffers) {
      for (const Pair& pair : buffer.*member) out[next++] = {pair[0], pair[1]};
    }
    std::sort(out.begin(), out.end(), less<Candidate>);
    return;
  }
  offsets.assign(static_cast<size_t>(id_count) + 1, 0);
  for (const PairBuffer& buffer : buffers) {
    for (const Pair& pair : buffer.*member) ++offsets[pair[0] + 1];
  }
  for (int32_t id = 0; id < id_count; ++id) offsets[id + 1] += offsets[id];
  for (const PairBuffer& buffer : buffers) {
    for (const Pair& pair : buffer.*member) out[offsets[pair[0]]++] = {pair[0], pair[1]};
  }
  // offsets[id] is now the end of the pairs of id.
  for (int32_t id = 0, begin = 0; id < id_count; begin = offsets[id++]) {
    if (offsets[id] - begin > 1) sort_bucket(out.data() + begin, out.data() + offsets[id]);
  }
}

/// Drops the pairs that the filter excludes by vertex.
void remove_excluded(const SurfaceMesh& mesh, const PairFilter& filter, CandidateList& list) {
  const auto is_out = [&](std::span<const int32_t> a, std::span<const int32_t> b) {
    return filter.excluded(a, mesh.vertex_group[a[0]], b, mesh.vertex_group[b[0]]);
  };
  const auto one = [](const int32_t& v) { return std::span(&v, 1); };
  std::erase_if(list.point_triangle, [&](const PointTriangleCandidate& c) {
    return is_out(one(c.point), mesh.triangles[c.triangle]);
  });
  std::erase_if(list.edge_edge, [&](const EdgeEdgeCandidate& c) {
    return is_out(mesh.edges[c.edge_a], mesh.edges[c.edge_b]);
  });
  std::erase_if(list.point_edge,
                [&](const PointEdgeCandidate& c) { return is_out(one(c.point), mesh.edges[c.edge]); });
  std::erase_if(list.point_point,
                [&](const PointPointCandidate& c) { return is_out(one(c.point_a), one(c.point_b)); });
}

}  // namespace

struct BroadPhase::Implementation {
  Bvh bvh;
  PairFilter filter;
  std::vector<PairBuffer> buffers;  // one per thread
  std::vector<int32_t> offsets[2];  // of points and of edges
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
                      CandidateList& out) {
  find_swept(x, x, group_inflation, pool, out);
}

void BroadPhase::find_swept(std::span<const Vec3> x0, std::span<const Vec3> x1,
                            std::span<const double> group_inflation, ThreadPool& pool, CandidateList& out) {
  Implementation& self = *implementation_;
  Bvh& bvh = self.bvh;
  bvh.refit(x0, x1, group_inflation, pool);
  self.buffers.resize(pool.thread_count());
  for (PairBuffer& buffer : self.buffers) buffer.clear();
  bvh.for_each_pair(self.filter, pool, [&](int thread, const Cell& a, const Cell& b, bool) {
    PairBuffer& buffer = self.buffers[thread];
    if (a.is_point()) {
      add_lone_point(bvh, a, b, buffer);
      return;
    }
    if (b.is_point()) {
      add_lone_point(bvh, b, a, buffer);
      return;
    }
    if (b.triangle >= 0)
      add_point_triangle(bvh, a, b, buffer.point_triangle);
    else
      add_point_edge(bvh, a, b, buffer.point_edge);
    if (a.triangle >= 0)
      add_point_triangle(bvh, b, a, buffer.point_triangle);
    else
      add_point_edge(bvh, b, a, buffer.point_edge);
    add_edge_edge(bvh, a, b, buffer.edge_edge);
  });
  const SurfaceMesh& mesh = bvh.mesh();
  const int32_t edge_count = static_cast<int32_t>(mesh.edges.size());
  const auto merge_list = [&](int64_t list, int) {
    std::vector<int32_t>& offsets = self.offsets[list];
    const std::vector<PairBuffer>& buffers = self.buffers;
    if (list == 0) {
      merge_sorted(buffers, &PairBuffer::point_triangle, mesh.vertex_count, offsets, out.point_triangle);
      merge_sorted(buffers, &PairBuffer::point_edge, mesh.vertex_count, offsets, out.point_edge);
      merge_sorted(buffers, &PairBuffer::point_point, mesh.vertex_count, offsets, out.point_point);
    } else {
      merge_sorted(buffers, &PairBuffer::edge_edge, edge_count, offsets, out.edge_edge);
    }
  };
  size_t found = 0;
  for (const PairBuffer& buffer : self.buffers) found += buffer.edge_edge.size();
  constexpr size_t kParallelMerge = 10000;  // fewer are sorted before the other threads wake up
  if (found > kParallelMerge) {
    pool.for_each_task(2, merge_list);
  } else {
    merge_list(0, 0);
    merge_list(1, 0);
  }
  if (self.filter.has_exclusions()) remove_excluded(mesh, self.filter, out);
  if (self.filter.has_neighbours())
    std::erase_if(out.point_edge, [&](const PointEdgeCandidate& c) {
      return self.filter.are_neighbours(c.point, mesh.edges[c.edge]);
    });
}

}  // namespace stark
