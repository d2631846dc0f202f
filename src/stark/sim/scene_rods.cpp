// Scene: rods. Checks, frames of their nodes.
#include <stark/base/error.h>
#include <stark/geometry/polyline.h>
#include <stark/sim/body_checks.h>
#include <stark/sim/material_fields.h>

namespace stark {

BodyId Scene::add_rod(RodDescription body) {
  body.name = unique_name(body.name, BodyKind::Rod);
  const std::string owner = owner_text(BodyKind::Rod, body.name);
  std::vector<std::string> warnings;
  validate(body.material, owner);
  check_polyline(owner, "the polyline", body.mesh.vertices);
  check_initial_positions(owner, body.initial_positions, body.mesh.vertices.size());
  if (!body.initial_positions.empty()) check_polyline(owner, "initial_positions", body.initial_positions);
  if (body.normal) check_normal(owner, *body.normal, body.mesh.vertices);
  if (body.normal && !body.initial_positions.empty())
    check_normal(owner, *body.normal, body.initial_positions);
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
