#include <stark/mechanics/loop_system.h>

#include <algorithm>
#include <functional>

namespace stark {

namespace {

void sort_once(std::vector<int32_t>& numbers) {
  std::ranges::sort(numbers);
  const auto doubled = std::ranges::unique(numbers);
  numbers.erase(doubled.begin(), doubled.end());
}

/// Place of a number in a sorted list that has it.
int32_t place_in(const std::vector<int32_t>& numbers, int32_t number) {
  return static_cast<int32_t>(std::ranges::lower_bound(numbers, number) - numbers.begin());
}

bool is_of_body(const Site& site) {
  return site.kind == SiteKind::RigidPoint || site.kind == SiteKind::RigidDirection;
}

template <typename Value>
std::vector<Value> values_of(const std::vector<Value>& all, const std::vector<int32_t>& numbers) {
  std::vector<Value> values;
  values.reserve(numbers.size());
  for (const int32_t number : numbers) values.push_back(all[number]);
  return values;
}

}  // namespace

LoopSystem::LoopSystem(const KinematicMap& map, const ConstraintSet& constraints,
                       const std::vector<bool>& chosen)
    : constraints_({}) {
  choose_elements(constraints, chosen);
  choose_sites(map, constraints);
  map_ = make_map(map);
  constraints_ = ConstraintSet(make_groups(constraints));
}

void LoopSystem::choose_elements(const ConstraintSet& constraints, const std::vector<bool>& chosen) {
  const std::vector<ConstraintGroup>& groups = constraints.groups();
  for (size_t g = 0; g < groups.size(); ++g) {
    std::vector<int64_t> elements;
    for (int64_t e = 0; e < groups[g].batch.size(); ++e) {
      const int32_t joint = groups[g].joints[e];
      if (!chosen[joint]) continue;
      elements.push_back(e);
      for (size_t k = 0; k < groups[g].joint->units().size(); ++k)
        rows_.push_back(static_cast<size_t>(constraints.place(joint).residual) + k);
    }
    if (elements.empty()) continue;
    from_.groups.push_back(static_cast<int32_t>(g));
    from_.elements.push_back(std::move(elements));
  }
}

void LoopSystem::choose_sites(const KinematicMap& map, const ConstraintSet& constraints) {
  const int32_t all_points = static_cast<int32_t>(map.layout().point_block.size());
  // Points that follow others, as embedded vertices do, bring those along.
  const std::function<void(int32_t)> choose_point = [&](int32_t p) {
    from_.points.push_back(p);
    if (map.is_embedded(p))
      for (const int32_t followed : map.support(p).points) choose_point(followed);
  };
  for (size_t g = 0; g < from_.groups.size(); ++g)
    for (const int64_t e : from_.elements[g])
      for (const int32_t s : constraints.groups()[from_.groups[g]].batch.stencil(e)) {
        const Site& site = map.site(s);
        if (s < all_points) {
          choose_point(s);
          continue;
        }
        from_.sites.push_back(s);
        if (site.kind == SiteKind::Point) choose_point(site.index);
        if (is_of_body(site)) from_.bodies.push_back(site.index);
        for (const int32_t p : map.support(s).points) choose_point(p);
      }
  sort_once(from_.points);
  sort_once(from_.bodies);
  // The sites of points are numbered like these, before all others.
  from_.sites.insert(from_.sites.end(), from_.points.begin(), from_.points.end());
  sort_once(from_.sites);
}

KinematicMap LoopSystem::make_map(const KinematicMap& map) const {
  const DofLayout& all = map.layout();
  DofLayout layout;
  const auto number = [&](int32_t block) { return block == kNoBlock ? kNoBlock : layout.block_count++; };
  for (const int32_t p : from_.points) layout.point_block.push_back(number(all.point_block[p]));
  for (const int32_t b : from_.bodies) {
    layout.body_block.push_back(number(all.body_block[b]));
    layout.rotation_block.push_back(number(all.rotation_block[b]));
  }
  std::vector<Site> sites;
  EmbeddedPoints embedded;
  for (const int32_t s : from_.sites) {
    Site site = map.site(s);
    if (site.kind == SiteKind::Point) site.index = place_in(from_.points, site.index);
    if (is_of_body(site)) site.index = place_in(from_.bodies, site.index);
    if (site.kind == SiteKind::Barycentric)
      for (int32_t& p : site.points) p = place_in(from_.points, p);
    if (site.kind == SiteKind::Embedded) {
      const SiteSupport support = map.support(s);
      std::vector<int32_t> points;
      for (const int32_t p : support.points) points.push_back(place_in(from_.points, p));
      site.index = embedded.add_row(embedded.add_support(points), support.weights);
    }
    sites.push_back(site);
  }
  return KinematicMap(std::move(layout), std::move(sites), std::move(embedded));
}

std::vector<ConstraintGroup> LoopSystem::make_groups(const ConstraintSet& constraints) const {
  std::vector<ConstraintGroup> groups;
  int32_t joint = 0;
  for (size_t g = 0; g < from_.groups.size(); ++g) {
    const ConstraintGroup& all = constraints.groups()[from_.groups[g]];
    ConstraintGroup group{all.joint, PotentialBatch(all.joint->potential()), {}};
    std::vector<int32_t> stencils;
    for (const int64_t e : from_.elements[g]) {
      for (const int32_t s : all.batch.stencil(e)) stencils.push_back(place_in(from_.sites, s));
      group.joints.push_back(joint++);
    }
    group.batch.resize(stencils);
    groups.push_back(std::move(group));
  }
  return groups;
}

void LoopSystem::read(const ConstraintSet& constraints, const Configuration& configuration,
                      std::span<const Vec3> x) {
  for (size_t g = 0; g < from_.groups.size(); ++g)
    constraints_.groups()[g].batch.take(constraints.groups()[from_.groups[g]].batch, from_.elements[g]);
  configuration_ = {values_of(configuration.point_position, from_.points),
                    values_of(configuration.body_position, from_.bodies),
                    values_of(configuration.body_rotation, from_.bodies)};
  x_.clear();
  for (const int32_t s : from_.sites) x_.push_back(x[s]);
  const ConstraintSet::Inputs all = constraints.inputs();
  constraints_.set_inputs({part(all.multipliers), part(all.penalties)});
}

}  // namespace stark
