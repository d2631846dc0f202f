#include <stark/contact/surface_motion.h>

#include <algorithm>
#include <utility>

#include <stark/base/rotation.h>

namespace stark {

namespace {

/// Orthonormal axes of a triangle as columns.
Mat3 axes_of(const Vec3& a, const Vec3& b, const Vec3& c) {
  const Vec3 e = normalized(b - a), n = normalized(cross(b - a, c - a)), f = cross(n, e);
  return Mat3::from_columns(e, f, n);
}

/// Rotation of the frame of a surface with sites at x.
Mat3 rotation_of(const MovingSurface& surface, std::span<const Vec3> x) {
  const auto& [a, b, c] = surface.sites;
  const auto& [p, q, r] = surface.local;
  return axes_of(x[a], x[b], x[c]) * transpose(axes_of(p, q, r));
}

}  // namespace

MovingSurfaces::MovingSurfaces(std::vector<MovingSurface> surfaces) : surfaces_(std::move(surfaces)) {
  for (size_t k = 0; k < surfaces_.size(); ++k) {
    const auto group = static_cast<size_t>(surfaces_[k].group);
    if (surface_of_group_.size() <= group) surface_of_group_.resize(group + 1, -1);
    surface_of_group_[group] = static_cast<int32_t>(k);
  }
}

void MovingSurfaces::set(std::span<const Vec3> velocities, std::span<const Vec3> spins) {
  for (size_t k = 0; k < surfaces_.size(); ++k) {
    surfaces_[k].motion.velocity = velocities[k];
    surfaces_[k].motion.spin = spins[k];
  }
}

const MovingSurface* MovingSurfaces::find(int32_t group) const {
  const auto g = static_cast<size_t>(group);
  return g < surface_of_group_.size() && surface_of_group_[g] >= 0 ? &surfaces_[surface_of_group_[g]]
                                                                   : nullptr;
}

Vec3 MovingSurfaces::way(int32_t group, const Vec3& point, std::span<const Vec3> x, double duration,
                         bool is_chord) const {
  const MovingSurface* surface = find(group);
  if (surface == nullptr) return {};
  const SurfaceMotion& motion = surface->motion;
  const Mat3 rotation = rotation_of(*surface, x);
  const Vec3 center = x[surface->sites[0]] + rotation * (motion.center - surface->local[0]);
  const Vec3 turn = rotation * motion.spin * duration, lever = point - center;
  return rotation * motion.velocity * duration +
         (is_chord ? lever - exp_rotation(turn * -1.0) * lever : cross(turn, lever));
}

double MovingSurfaces::turn(int32_t group, const Vec3& normal, std::span<const Vec3> x,
                            double duration) const {
  const MovingSurface* surface = find(group);
  return surface == nullptr ? 0.0 : dot(normal, rotation_of(*surface, x) * surface->motion.spin) * duration;
}

}  // namespace stark
