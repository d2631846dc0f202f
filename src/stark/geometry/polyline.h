// Polylines: tangents at their points, frames that do not twist along them. Phase: scene description.
#pragma once

#include <optional>
#include <span>
#include <vector>

#include <stark/base/math.h>

namespace stark {

/// Lengths of the edges between consecutive points [m].
std::vector<double> polyline_lengths(std::span<const Vec3> points);

/// Unit tangent at each point: of the edge at the ends, halfway between the directions of both edges inside.
std::vector<Vec3> polyline_tangents(std::span<const Vec3> points);

/// Right-handed frame at each point with the columns d1, d2 and the tangent d3. d1 of the first point is
/// `normal`, made perpendicular to the tangent; without one, the coordinate axis farthest from the tangent is
/// taken. The others follow by parallel transport, which turns each frame into the next by the smallest
/// rotation that takes tangent to tangent: no twist. [Bergou et al. 2008, "Discrete Elastic Rods",
/// sec. 4.2.2] Consecutive tangents must not be opposite, `normal` not along the first tangent.
std::vector<Mat3> polyline_frames(std::span<const Vec3> points, const std::optional<Vec3>& normal = {});

/// Points on the straight line through the first one along `direction` (unit) with the same edge lengths.
std::vector<Vec3> straightened(std::span<const Vec3> points, const Vec3& direction);

}  // namespace stark
