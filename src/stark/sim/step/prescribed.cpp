#include <stark/sim/step/prescribed.h>

#include <algorithm>
#include <cmath>

#include <stark/collision/distant_pairs.h>
#include <stark/collision/intersection.h>
#include <stark/collision/max_safe_step.h>

namespace stark {

namespace {

/// Overlap over the size of the smaller body below which two bodies touch.
constexpr double kTouch = 1e-6;

/// Straight parts of the way of bodies that turn: by an eighth of half a turn in a step at most.
constexpr int kStations = 8;

/// By which the box of a way is enlarged, over its size: more than arcs rise above their chords.
constexpr double kRise = 0.03;

using Box = PrescribedBodies::Box;

Box common(const Box& a, const Box& b) {
  Box box;
  for (int k = 0; k < 3; ++k)
    box.low[k] = std::fmax(a.low[k], b.low[k]), box.high[k] = std::fmin(a.high[k], b.high[k]);
  return box;
}

template <typename Primitive>
void copy_primitives(const std::vector<Primitive>& from, const std::vector<int32_t>& groups,
                     const std::vector<bool>& wanted, std::vector<Primitive>& to,
                     std::vector<int32_t>& to_groups) {
  for (size_t k = 0; k < from.size(); ++k) {
    if (!wanted[groups[k]]) continue;
    to.push_back(from[k]);
    to_groups.push_back(groups[k]);
  }
}

}  // namespace

PrescribedBodies::PrescribedBodies(const Scene& scene, const SurfaceMesh& surface)
    : group_count_(scene.body_count()) {
  std::vector<bool> wanted(group_count_, false);
  for (int32_t a = 0; a < group_count_; ++a) {
    is_filled_.push_back(scene.is_filled(BodyId{a}));
    for (int32_t b = a + 1; b < group_count_; ++b) {
      if (!scene.meeting_matters(BodyId{a}, BodyId{b})) continue;
      pairs_.push_back({a, b});
      wanted[a] = wanted[b] = true;
    }
  }
  sites_.resize(group_count_);
  touch_.resize(group_count_);
  if (pairs_.empty()) return;
  mesh_.vertex_count = surface.vertex_count;
  mesh_.vertex_group = surface.vertex_group;
  for (const int32_t v : surface.inner)
    if (wanted[surface.vertex_group[v]]) mesh_.inner.push_back(v);
  copy_primitives(surface.edges, surface.edge_group, wanted, mesh_.edges, mesh_.edge_group);
  copy_primitives(surface.triangles, surface.triangle_group, wanted, mesh_.triangles, mesh_.triangle_group);
  for (size_t t = 0; t < mesh_.triangles.size(); ++t)
    for (const int32_t v : mesh_.triangles[t]) sites_[mesh_.triangle_group[t]].push_back(v);
  for (std::vector<int32_t>& sites : sites_) {
    std::ranges::sort(sites);
    sites.erase(std::ranges::unique(sites).begin(), sites.end());
  }
}

std::vector<PrescribedBodies::Pair> PrescribedBodies::find_meetings(std::span<const Vec3> start,
                                                                    std::span<const Vec3> end,
                                                                    const Path& path, ThreadPool& pool) {
  if (pairs_.empty()) return {};
  std::vector<Box> ways(sites_.size()), places(sites_.size());
  for (size_t b = 0; b < sites_.size(); ++b) {
    for (const int32_t v : sites_[b]) places[b].add(end[v]), ways[b].add(start[v]), ways[b].add(end[v]);
    if (sites_[b].empty()) continue;
    touch_[b] = kTouch * places[b].size();
    ways[b].enlarge(kRise * ways[b].size());
  }
  std::vector<Pair> found;
  for (const Pair& pair : pairs_) {
    const Box &a = ways[pair[0]], &b = ways[pair[1]];
    if (!a.overlaps(b)) continue;
    const Local local{part_between(pair, common(a, b), start, end), only(pair), pair};
    if (overlap(local, end, pool) || contains(pair, places[pair[0]], places[pair[1]], end, pool) ||
        pass_through(local, start, end, path, pool))
      found.push_back(pair);
  }
  return found;
}

PairFilter PrescribedBodies::only(const Pair& pair) const {
  PairFilter filter(group_count_, false, false);
  filter.set(pair[0], pair[1], true);
  return filter;
}

SurfaceMesh PrescribedBodies::part_between(const Pair& pair, const Box& region, std::span<const Vec3> start,
                                           std::span<const Vec3> end) const {
  SurfaceMesh part;
  part.vertex_count = mesh_.vertex_count;
  part.vertex_group = mesh_.vertex_group;
  part.inner = mesh_.inner;
  const auto copy = [&](const auto& from, const std::vector<int32_t>& groups, auto& to,
                        std::vector<int32_t>& to_groups) {
    for (size_t k = 0; k < from.size(); ++k) {
      if (groups[k] != pair[0] && groups[k] != pair[1]) continue;
      Box box;
      for (const int32_t v : from[k]) box.add(start[v]), box.add(end[v]);
      if (!box.overlaps(region)) continue;
      to.push_back(from[k]);
      to_groups.push_back(groups[k]);
    }
  };
  copy(mesh_.edges, mesh_.edge_group, part.edges, part.edge_group);
  copy(mesh_.triangles, mesh_.triangle_group, part.triangles, part.triangle_group);
  return part;
}

bool PrescribedBodies::overlap(const Local& local, std::span<const Vec3> x, ThreadPool& pool) const {
  if (find_intersections(local.mesh, x, local.filter, pool).empty()) return false;
  const double way = std::max(touch_[local.pair[0]], touch_[local.pair[1]]);
  for (int direction = 0; direction < 6; ++direction) {
    std::vector<Vec3> moved(x.begin(), x.end());
    for (const int32_t v : sites_[local.pair[0]]) moved[v][direction / 2] += direction % 2 == 0 ? way : -way;
    if (find_intersections(local.mesh, moved, local.filter, pool).empty()) return false;
  }
  return true;
}

bool PrescribedBodies::contains(const Pair& pair, const Box& a, const Box& b, std::span<const Vec3> x,
                                ThreadPool& pool) const {
  if (!a.contains(b) && !b.contains(a)) return false;
  return !find_contained_groups(mesh_, x, only(pair), pool, is_filled_).empty();
}

bool PrescribedBodies::pass_through(const Local& local, std::span<const Vec3> start,
                                    std::span<const Vec3> end, const Path& path, ThreadPool& pool) const {
  const auto rests = [&](int32_t body) {
    return std::ranges::all_of(sites_[body], [&](int32_t v) { return start[v] == end[v]; });
  };
  if (rests(local.pair[0]) && rests(local.pair[1])) return false;
  BroadPhase broad_phase;
  broad_phase.reset(local.mesh, local.filter);
  CandidateList list;
  broad_phase.find(start, touch_, pool, list);
  remove_distant(local.mesh, touch_, start, pool, list);
  if (list.size() > 0 || !find_intersections(local.mesh, start, local.filter, pool).empty()) return false;
  constexpr double kEnd = 0.99;  // bodies that come to touch do not meet
  const std::vector<double> none(static_cast<size_t>(group_count_), 0.0);
  std::vector<Vec3> before(start.begin(), start.end());
  for (int k = 1; k <= kStations; ++k) {
    std::vector<Vec3> x = path(static_cast<double>(k) / kStations);
    CcdReport report;
    broad_phase.find_swept(before, x, none, pool, list);
    const double step = max_safe_step(local.mesh, list, before, x, Separations{.by_group = none}, pool,
                                      &report, {.time_margin = 0.0});
    if (report.kind && step < (k == kStations ? kEnd : 1.0)) return true;
    before = std::move(x);
  }
  return false;
}

}  // namespace stark
