#include <stark/mechanics/kinematic_map.h>

#include <algorithm>

#include <stark/base/for_each_range.h>
#include <stark/base/rotation.h>

namespace stark {

namespace {

constexpr int64_t kSitesPerTask = 8192;

/// Whether rotation leaves the site where it is: centres of mass and nodes of rods.
bool is_centre(const Site& site) { return site.local == Vec3{}; }

}  // namespace

KinematicMap::KinematicMap(DofLayout layout, std::vector<Site> sites, EmbeddedPoints embedded,
                           std::vector<TurningRange> turning)
    : layout_(std::move(layout)),
      sites_(std::move(sites)),
      embedded_(std::move(embedded)),
      turning_(std::move(turning)) {
  for (const int32_t p : embedded_.points) support_block_.push_back(layout_.point_block[p]);
  for (int32_t p = 0; p < static_cast<int32_t>(std::min(layout_.point_block.size(), sites_.size())); ++p)
    if (is_embedded(p)) followers_.push_back(p);
  std::vector<int32_t> blocks;
  for (int32_t i = 0; i < site_count(); ++i) {
    blocks.clear();
    append_blocks(i, blocks);
    prescribed_.push_back(blocks.empty());
  }
  find_runs();
}

void KinematicMap::find_runs() {
  bool has_bodies = false;
  for (int32_t i = 0; i < site_count(); ++i) {
    const Site& site = sites_[i];
    const bool is_point = site.kind == SiteKind::Point;
    const bool is_of_body = site.kind == SiteKind::RigidPoint || site.kind == SiteKind::RigidDirection;
    has_bodies = has_bodies || is_of_body;
    if (!runs_.empty() && runs_.back().kind == site.kind) {
      Run& run = runs_.back();
      const int32_t next = is_point ? run.index + (i - run.begin) : run.index;
      if ((!is_point && !is_of_body) || site.index == next) {
        run.end = i + 1;
        continue;
      }
    }
    runs_.push_back({site.kind, i, i + 1, site.index});
  }
  if (!has_bodies) return;
  for (const Site& site : sites_) local_.push_back(site.local);
}

SiteSupport KinematicMap::support(int32_t i) const {
  const Site& site = sites_[i];
  if (site.kind == SiteKind::Barycentric) return {site.points, site.weights};
  if (site.kind != SiteKind::Embedded) return {};
  return {embedded_.points_of(embedded_.support[site.index]), embedded_.weights_of(site.index)};
}

void KinematicMap::follow(std::span<Vec3> by_point) const {
  for (const int32_t p : followers_) by_point[p] = point_sum(support(p), by_point);
}

void KinematicMap::positions(const Configuration& configuration, std::span<Vec3> out_x, ThreadPool* pool,
                             std::span<const uint8_t> resting) const {
  const auto rests = [&](const Run& run) {
    const bool is_of_body = run.kind == SiteKind::RigidPoint || run.kind == SiteKind::RigidDirection;
    return is_of_body && !resting.empty() && resting[run.index] != 0;
  };
  const auto place_range = [&](int64_t begin, int64_t end) {
    auto run = std::ranges::upper_bound(runs_, begin, {}, &Run::begin) - 1;
    for (; run != runs_.end() && run->begin < end; ++run) {
      if (rests(*run)) continue;
      Run part = *run;
      part.begin = std::max(run->begin, static_cast<int32_t>(begin));
      part.end = std::min(run->end, static_cast<int32_t>(end));
      if (run->kind == SiteKind::Point) part.index += part.begin - run->begin;
      place(part, configuration, out_x);
    }
  };
  if (sites_.empty()) return;
  for_each_range(pool, site_count(), kSitesPerTask, place_range);
}

void KinematicMap::place(const Run& run, const Configuration& configuration, std::span<Vec3> out_x) const {
  switch (run.kind) {
    case SiteKind::Point:
      std::copy_n(configuration.point_position.begin() + run.index, run.end - run.begin,
                  out_x.begin() + run.begin);
      break;
    case SiteKind::RigidPoint:
    case SiteKind::RigidDirection: {
      const Mat3 R = configuration.body_rotation[run.index];
      if (run.kind == SiteKind::RigidDirection) {
        for (int32_t i = run.begin; i < run.end; ++i) out_x[i] = R * local_[i];
        break;
      }
      const Vec3 centre = configuration.body_position[run.index];
      for (int32_t i = run.begin; i < run.end; ++i) out_x[i] = centre + R * local_[i];
      break;
    }
    case SiteKind::Barycentric:
    case SiteKind::Embedded:
      for (int32_t i = run.begin; i < run.end; ++i)
        out_x[i] = point_sum(support(i), configuration.point_position);
      break;
    case SiteKind::World:
      for (int32_t i = run.begin; i < run.end; ++i) out_x[i] = sites_[i].local;
      break;
  }
}

SiteJacobian KinematicMap::jacobian(int32_t i, const Configuration& configuration) const {
  const Site& site = sites_[i];
  SiteJacobian jacobian;
  const auto add = [&](int32_t block, double weight) {
    if (block != kNoBlock && weight != 0.0)
      jacobian.terms[jacobian.term_count++] = {.block = block, .weight = weight};
  };
  const auto add_rotation = [&] {
    const int32_t block = layout_.rotation_block[site.index];
    if (block == kNoBlock || is_centre(site)) return;
    jacobian.body = site.index;
    jacobian.lever = configuration.body_rotation[site.index] * site.local;
    jacobian.terms[jacobian.term_count++] = {.block = block, .is_rotation = true};
  };
  switch (site.kind) {
    case SiteKind::Point:
      add(layout_.point_block[site.index], 1.0);
      break;
    case SiteKind::RigidPoint:
      add(layout_.body_block[site.index], 1.0);
      add_rotation();
      break;
    case SiteKind::RigidDirection:
      add_rotation();
      break;
    case SiteKind::Barycentric:
      for (int k = 0; k < 4; ++k) add(layout_.point_block[site.points[k]], site.weights[k]);
      break;
    case SiteKind::Embedded:
      jacobian.support_blocks = support_blocks(support_index(i));
      jacobian.support_weights = embedded_.weights_of(site.index);
      break;
    case SiteKind::World:
      break;
  }
  return jacobian;
}

void KinematicMap::append_blocks(int32_t i, std::vector<int32_t>& out_blocks) const {
  const Site& site = sites_[i];
  const auto add = [&](int32_t block) {
    if (block != kNoBlock) out_blocks.push_back(block);
  };
  switch (site.kind) {
    case SiteKind::Point:
      add(layout_.point_block[site.index]);
      break;
    case SiteKind::RigidPoint:
    case SiteKind::RigidDirection:
      if (site.kind == SiteKind::RigidPoint) add(layout_.body_block[site.index]);
      if (!is_centre(site)) add(layout_.rotation_block[site.index]);
      break;
    case SiteKind::Barycentric:
      for (int k = 0; k < 4; ++k)
        if (site.weights[k] != 0.0) add(layout_.point_block[site.points[k]]);
      break;
    case SiteKind::Embedded:
      for (const int32_t block : support_blocks(support_index(i))) add(block);
      break;
    case SiteKind::World:
      break;
  }
}

KinematicMap::Way KinematicMap::retract(const Configuration& configuration, std::span<const double> direction,
                                        double alpha, Way way, Configuration& out) const {
  const auto increment = [&](int32_t block) {
    return Vec3{direction[3 * block], direction[3 * block + 1], direction[3 * block + 2]} * alpha;
  };
  out = configuration;
  for (size_t p = 0; p < out.point_position.size(); ++p)
    if (const int32_t block = layout_.point_block[p]; block != kNoBlock)
      out.point_position[p] += increment(block);
  for (size_t b = 0; b < out.body_position.size(); ++b) {
    if (const int32_t block = layout_.body_block[b]; block != kNoBlock)
      out.body_position[b] += increment(block);
    if (const int32_t block = layout_.rotation_block[b]; block != kNoBlock)
      out.body_rotation[b] = exp_rotation(increment(block)) * configuration.body_rotation[b];
  }
  const Way taken = way == Way::Turning ? turn(configuration, direction, alpha, out) : Way::Straight;
  follow(out.point_position);
  return taken;
}

KinematicMap::Way KinematicMap::turn(const Configuration& from, std::span<const double> direction,
                                     double alpha, Configuration& out) const {
  Way way = Way::Straight;
  for (const TurningRange& range : turning_) {
    const bool turns =
        range.are_nodes ? complete_turn(range, range.of(from.body_position), range.of(layout_.body_block),
                                        direction, alpha, range.of(out.body_position))
                        : complete_turn(range, range.of(from.point_position), range.of(layout_.point_block),
                                        direction, alpha, range.of(out.point_position));
    if (turns) way = Way::Turning;
  }
  return way;
}

}  // namespace stark
