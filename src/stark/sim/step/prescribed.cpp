#include <stark/sim/step/prescribed.h>

#include <algorithm>
#include <cmath>
#include <numeric>

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

Box box_of(std::span<const int32_t> sites, std::span<const Vec3> x) {
  Box box;
  for (const int32_t site : sites) box.add(x[site]);
  return box;
}

bool rests(std::span<const int32_t> sites, std::span<const Vec3> start, std::span<const Vec3> end) {
  return std::ranges::all_of(sites, [&](int32_t site) { return start[site] == end[site]; });
}

}  // namespace

PrescribedBodies::PrescribedBodies(const Scene& scene, const SurfaceMesh& surface) {
  std::vector<int32_t> place(scene.body_count(), -1);  // in bodies_
  bool is_any_scripted = false;
  for (int32_t b = 0; b < scene.body_count(); ++b) {
    const Motion motion = scene.motion(BodyId{b});
    if (motion == Motion::Dynamic) continue;
    place[b] = static_cast<int32_t>(bodies_.size());
    bodies_.push_back(
        {.number = b, .is_scripted = motion == Motion::Scripted, .is_filled = scene.is_filled(BodyId{b})});
    is_any_scripted |= bodies_.back().is_scripted;
  }
  if (!is_any_scripted) bodies_.clear();
  if (bodies_.empty()) return;
  without_ = scene.pairs_kept_apart();
  without_.insert(scene.pairs_without_contact().begin(), scene.pairs_without_contact().end());
  const auto deal = [&](const auto& primitives, const std::vector<int32_t>& groups, auto member) {
    for (size_t k = 0; k < primitives.size(); ++k)
      if (const int32_t b = place[groups[k]]; b >= 0) (bodies_[b].*member).push_back(primitives[k]);
  };
  deal(surface.edges, surface.edge_group, &Body::edges);
  deal(surface.triangles, surface.triangle_group, &Body::triangles);
  for (const int32_t v : surface.inner)
    if (const int32_t b = place[surface.vertex_group[v]]; b >= 0) bodies_[b].inner.push_back(v);
  for (Body& body : bodies_) {
    for (const Index3& triangle : body.triangles)
      body.sites.insert(body.sites.end(), triangle.begin(), triangle.end());
    std::ranges::sort(body.inner);
    std::ranges::sort(body.sites);
    body.sites.erase(std::ranges::unique(body.sites).begin(), body.sites.end());
  }
  std::erase_if(bodies_, [](const Body& body) { return body.sites.empty(); });
}

std::vector<PrescribedBodies::Pair> PrescribedBodies::find_meetings(std::span<const Vec3> start,
                                                                    std::span<const Vec3> end,
                                                                    const Path& path, ThreadPool& pool) {
  for (Body& body : bodies_) {
    body.place = body.way = box_of(body.sites, end);
    body.touch = kTouch * body.place.size();
    body.rests = rests(body.sites, start, end);
    if (body.rests) continue;
    for (const int32_t site : body.sites) body.way.add(start[site]);
    body.way.enlarge(kRise * body.way.size());
  }
  std::vector<int32_t> order(bodies_.size());
  std::iota(order.begin(), order.end(), 0);
  std::ranges::sort(order, {}, [&](int32_t b) { return std::pair(bodies_[b].way.low[0], b); });
  Stations stations{path, {}};
  std::vector<Pair> found;
  for (size_t i = 0; i < order.size(); ++i)
    for (size_t j = i + 1; j < order.size(); ++j) {
      const auto& [low, high] = std::minmax(order[i], order[j]);
      const Body &a = bodies_[low], &b = bodies_[high];
      if (bodies_[order[j]].way.low[0] > bodies_[order[i]].way.high[0]) break;
      if (!a.is_scripted && !b.is_scripted) continue;
      if (!a.way.overlaps(b.way) || without_.contains({a.number, b.number})) continue;
      if (meet(a, b, start, end, stations, pool)) found.push_back({a.number, b.number});
    }
  std::ranges::sort(found);
  return found;
}

bool PrescribedBodies::meet(const Body& a, const Body& b, std::span<const Vec3> start,
                            std::span<const Vec3> end, Stations& stations, ThreadPool& pool) {
  if ((a.place.contains(b.place) || b.place.contains(a.place)) && contains(a, b, end, pool)) return true;
  const Local local = part_between(a, b, start, end);
  if (!local.has_both) return false;
  if (overlap(local, end, std::max(a.touch, b.touch), pool)) return true;
  return !(a.rests && b.rests) && pass_through(local, {a.touch, b.touch}, start, stations, pool);
}

std::vector<Vec3> PrescribedBodies::Local::gather(std::span<const Vec3> x) const {
  std::vector<Vec3> own;
  own.reserve(sites.size());
  for (const int32_t site : sites) own.push_back(x[site]);
  return own;
}

PrescribedBodies::Local PrescribedBodies::part_between(const Body& a, const Body& b,
                                                       std::span<const Vec3> start,
                                                       std::span<const Vec3> end) {
  const Box region = common(a.way, b.way);
  return make_local(a, b, [&](const auto& primitive) {
    Box box;
    for (const int32_t v : primitive) box.add(start[v]), box.add(end[v]);
    return box.overlaps(region);
  });
}

template <typename IsWanted>
PrescribedBodies::Local PrescribedBodies::make_local(const Body& a, const Body& b, IsWanted&& is_wanted) {
  Local local{.filter = PairFilter(2, true, false)};
  SurfaceMesh& mesh = local.mesh;
  int32_t group = 0;
  size_t counts[2] = {};
  for (const Body* body : {&a, &b}) {
    const auto copy = [&](const auto& from, auto& to, std::vector<int32_t>& to_group) {
      for (const auto& primitive : from) {
        if (!is_wanted(primitive)) continue;
        to.push_back(primitive);
        to_group.push_back(group);
        local.sites.insert(local.sites.end(), primitive.begin(), primitive.end());
        ++counts[group];
      }
    };
    copy(body->edges, mesh.edges, mesh.edge_group);
    copy(body->triangles, mesh.triangles, mesh.triangle_group);
    ++group;
  }
  local.has_both = counts[0] > 0 && counts[1] > 0;
  std::ranges::sort(local.sites);
  local.sites.erase(std::ranges::unique(local.sites).begin(), local.sites.end());
  const auto renumber = [&](auto& primitives) {
    for (auto& primitive : primitives)
      for (int32_t& v : primitive)
        v = static_cast<int32_t>(std::ranges::lower_bound(local.sites, v) - local.sites.begin());
  };
  renumber(mesh.edges);
  renumber(mesh.triangles);
  mesh.vertex_count = static_cast<int32_t>(local.sites.size());
  for (int32_t v = 0; v < mesh.vertex_count; ++v) {
    const int32_t site = local.sites[v];
    const bool is_of_a = std::ranges::binary_search(a.sites, site);
    mesh.vertex_group.push_back(is_of_a ? 0 : 1);
    if (std::ranges::binary_search((is_of_a ? a : b).inner, site)) mesh.inner.push_back(v);
  }
  return local;
}

bool PrescribedBodies::overlap(const Local& local, std::span<const Vec3> end, double way, ThreadPool& pool) {
  const std::vector<Vec3> x = local.gather(end);
  if (find_intersections(local.mesh, x, local.filter, pool).empty()) return false;
  for (int direction = 0; direction < 6; ++direction) {
    std::vector<Vec3> moved = x;
    for (size_t v = 0; v < moved.size(); ++v)
      if (local.mesh.vertex_group[v] == 0) moved[v][direction / 2] += direction % 2 == 0 ? way : -way;
    if (find_intersections(local.mesh, moved, local.filter, pool).empty()) return false;
  }
  return true;
}

bool PrescribedBodies::contains(const Body& a, const Body& b, std::span<const Vec3> x, ThreadPool& pool) {
  const Local whole = make_local(a, b, [](const auto&) { return true; });
  return !find_contained_groups(whole.mesh, whole.gather(x), whole.filter, pool, {a.is_filled, b.is_filled})
              .empty();
}

const std::vector<Vec3>& PrescribedBodies::Stations::at(int k) {
  while (static_cast<int>(x.size()) < k) x.push_back(path(static_cast<double>(x.size() + 1) / kStations));
  return x[k - 1];
}

bool PrescribedBodies::pass_through(const Local& local, const std::vector<double>& touch,
                                    std::span<const Vec3> start, Stations& stations, ThreadPool& pool) {
  std::vector<Vec3> before = local.gather(start);
  BroadPhase broad_phase;
  broad_phase.reset(local.mesh, local.filter);
  CandidateList list;
  broad_phase.find(before, touch, pool, list);
  remove_distant(local.mesh, touch, before, pool, list);
  if (list.size() > 0 || !find_intersections(local.mesh, before, local.filter, pool).empty()) return false;
  constexpr double kEnd = 0.99;  // bodies that come to touch do not meet
  const std::vector<double> none(2, 0.0);
  for (int k = 1; k <= kStations; ++k) {
    std::vector<Vec3> x = local.gather(stations.at(k));
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
