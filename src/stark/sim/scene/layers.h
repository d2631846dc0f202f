// Geometry of layers: the sheet that a skin is, the frames of the nodes of fibres, lumped masses. Internal to
// sim. Phase: model building.
#pragma once

#include <span>
#include <vector>

#include <stark/sim/scene/scene.h>

namespace stark {

/// A skin as a cloth with all vertices of its body.
ClothDescription sheet_of(const Scene& scene, const SkinDescription& skin);

/// Points of a path, of a ring with the last one before the first and the first after the last, so that all
/// nodes have neighbours; `vertices` [m] are those of the body.
std::vector<Vec3> path_points(const std::vector<int32_t>& path, std::span<const Vec3> vertices);

/// Frames of the nodes of a path: at rest without twist along it, at time 0 turned with the body about the
/// fibre, so that the bearing of each neighbour is that of the rest shape.
struct PathFrames {
  std::vector<int32_t> neighbours;  ///< of each node: the vertex of an element with it farthest off the fibre
  std::vector<Mat3> rest;           ///< in the frame of the body
  std::vector<Mat3> initial;        ///< in the world at time 0
};
/// Of all paths.
std::vector<PathFrames> path_frames(const Scene& scene, const FibresDescription& fibres);
/// At time 0 in the world, path by path; none without bending.
std::vector<Mat3> initial_frames(const Scene& scene, const FibresDescription& fibres);

/// Rest lengths of all edges, path by path [m].
std::vector<double> fibre_lengths(const Scene& scene, const FibresDescription& fibres);
/// Masses of all edges, path by path [kg].
std::vector<double> fibre_masses(const Scene& scene, const FibresDescription& fibres);

}  // namespace stark
