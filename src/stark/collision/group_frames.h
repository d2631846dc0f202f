// Frames of groups that move as one piece. Four sites tell where all others are, so that bounds of positions
// and of displacements cost as much for a mesh of a million triangles as for a cube.
#pragma once

#include <array>
#include <cstdint>
#include <optional>
#include <span>

#include <stark/collision/bounds.h>

namespace stark {

/// A box around all sites of a group that turns and moves with it. Positions have to be an affine image of
/// those that the frame was made from, as those of rigid bodies are, also on the straight way between two of
/// them.
struct GroupFrame {
  std::array<int32_t, 4> sites{};
  std::array<std::array<double, 4>, 8> corners{};  ///< as weights of the four sites; each adds up to 1
  double rounding = 0.0;                           ///< of corners and sites, over the largest coordinate

  /// Bounds of all sites at x [m].
  Bounds bound(std::span<const Vec3> x) const;
  /// Bounds of the displacements of all sites from x0 to x1 [m].
  Bounds bound_motion(std::span<const Vec3> x0, std::span<const Vec3> x1) const;
  /// No site is farther from where it was at x0 [m].
  double farthest(std::span<const Vec3> x0, std::span<const Vec3> x1) const;
};

/// Three of the sites that span their motion, each far from those before it: from a site, from the line.
std::array<int32_t, 3> find_spanning_sites(std::span<const int32_t> sites, std::span<const Vec3> x);

/// The frame of these sites of x; none for few sites, which cost less by themselves, and for flat groups.
std::optional<GroupFrame> find_frame(std::span<const int32_t> sites, std::span<const Vec3> x);

}  // namespace stark
