// Scene: rods. Checks, frames of their nodes.
#include <cmath>

#include <stark/base/error.h>
#include <stark/geometry/polyline.h>
#include <stark/sim/body_checks.h>
#include <stark/sim/material_fields.h>

namespace stark {

namespace {

/// Smallest 1 + cos of the angle between consecutive edges: sharper bends have no tangent to speak of.
constexpr double kSharpestBend = 0.05;
/// Shortest edge over the longest one.
constexpr double kShortestEdge = 1e-6;
/// Sine of the smallest angle between the normal and the first tangent.
constexpr double kSmallestAngle = 1e-6;

void check_polyline(const std::string& owner, const std::string& what, std::span<const Vec3> points) {
  if (points.size() < 2)
    throw InvalidMesh(owner + ": " + what + " has " + std::to_string(points.size()) +
                      " points: must have at least 2, one for each node; use stark.mesh.polyline");
  for (size_t i = 0; i < points.size(); ++i)
    if (!is_finite(points[i]))
      throw InvalidMesh(owner + ": " + what + ": point " + std::to_string(i) + " = " +
                        to_text(FieldValue(points[i])) + " m: must be finite; check where it is computed");
  const std::vector<double> lengths = polyline_lengths(points);
  const double longest = *std::max_element(lengths.begin(), lengths.end());
  for (size_t i = 0; i < lengths.size(); ++i)
    if (!(lengths[i] > kShortestEdge * longest))
      throw InvalidMesh(owner + ": " + what + ": edge " + std::to_string(i) + " has a length of " +
                        quantity_text(lengths[i], "m") + ": must not be degenerate; remove a point");
  for (size_t i = 0; i + 1 < lengths.size(); ++i) {
    const double cosine =
        dot(points[i + 1] - points[i], points[i + 2] - points[i + 1]) / (lengths[i] * lengths[i + 1]);
    if (!(1.0 + cosine > kSharpestBend))
      throw InvalidMesh(owner + ": " + what + " turns by " + to_text(std::acos(std::max(-1.0, cosine))) +
                        " rad at point " + std::to_string(i + 1) +
                        ": must turn by less than 2.8 rad; round the bend with more points");
  }
}

void check_normal(const std::string& owner, const RodDescription& rod) {
  if (!rod.normal) return;
  check_finite(owner, "normal", *rod.normal, "1");
  const auto check_against = [&](std::span<const Vec3> points) {
    const Vec3 tangent = normalized(points[1] - points[0]);
    if (!(norm(cross(*rod.normal, tangent)) > kSmallestAngle * norm(*rod.normal)))
      throw InvalidArgument(
          owner + ": normal = " + to_text(FieldValue(*rod.normal)) +
          " is zero or along the first edge: must have a part across it; give the direction "
          "of the width of the section");
  };
  check_against(rod.mesh.vertices);
  if (!rod.initial_positions.empty()) check_against(rod.initial_positions);
}

}  // namespace

BodyId Scene::add_rod(RodDescription body) {
  body.name = unique_name(body.name, BodyKind::Rod);
  const std::string owner = owner_text(BodyKind::Rod, body.name);
  std::vector<std::string> warnings;
  validate(body.material, owner);
  check_polyline(owner, "the polyline", body.mesh.vertices);
  check_initial_positions(owner, body.initial_positions, body.mesh.vertices.size());
  if (!body.initial_positions.empty()) check_polyline(owner, "initial_positions", body.initial_positions);
  check_normal(owner, body);
  check_fields(owner, body);
  check_common(owner, body);
  warn_about_size(owner, body.mesh.vertices, warnings);
  warnings_.insert(warnings_.end(), warnings.begin(), warnings.end());
  rods_.push_back(std::move(body));
  return append(rods_.back().name, BodyKind::Rod, rods_.size() - 1);
}

void Scene::clamp(BodyId body, std::span<const int32_t> nodes) {
  if (kind(body) != BodyKind::Rod)
    throw InvalidArgument(owner_text(kind(body), name(body)) +
                          ": has no nodes with frames to clamp: only rods do; use pin");
  check_vertices(body, "clamped", nodes);
  append_new(pins_[at_index(body)].vertices, nodes);
  append_new(pins_[at_index(body)].clamped, nodes);
}

std::vector<Mat3> Scene::initial_frames(BodyId body) const {
  const RodDescription& rod = this->rod(body);
  std::vector<Mat3> frames =
      polyline_frames(rod.initial_positions.empty() ? rod.mesh.vertices : rod.initial_positions, rod.normal);
  for (Mat3& frame : frames) frame = rod.rotation * frame;
  return frames;
}

}  // namespace stark
