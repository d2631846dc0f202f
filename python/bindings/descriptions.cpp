#include "descriptions.h"

#include <nanobind/stl/pair.h>
#include <nanobind/stl/shared_ptr.h>
#include <nanobind/stl/vector.h>

namespace stark::bindings {

namespace {

PointSet points_of(const nb::dict& entries) {
  const Given given(entries, "points");
  std::string kind;
  BodyId body;
  int32_t node = -1;
  given.read("kind", kind);
  given.read("body", body);
  given.read("node", node);
  if (kind == "vertices")
    return vertex_points(
        body, numbers_of<int32_t>(entries["vertices"], "vertices", "a flat array of vertex indices"));
  if (kind == "embedded") {
    using Supports = std::array<int32_t, 4>;
    using Weights = std::array<double, 4>;
    return embedded_points(
        body, rows_of<Supports, int32_t, 4>(entries["supports"], "supports", "an (n, 4) array of vertices"),
        rows_of<Weights, double, 4>(entries["weights"], "weights", "an (n, 4) array"));
  }
  if (kind == "joined") {
    std::vector<PointSet> parts;
    for (const nb::handle part : entries["parts"]) parts.push_back(points_of(nb::cast<nb::dict>(part)));
    return joined_points(std::move(parts));
  }
  const auto local = rows_of<Vec3, double, 3>(entries["local"], "points", "an (n, 3) array");
  if (kind == "world") return world_points(local);
  if (kind == "point") return body_points(body, local);
  if (kind == "direction") return body_directions(body, local);
  return kind == "node_point" ? node_points(body, node, local) : node_directions(body, node, local);
}

std::vector<PointSet> point_sets_of(nb::handle list) {
  std::vector<PointSet> sets;
  for (const nb::handle set : list) sets.push_back(points_of(nb::cast<nb::dict>(set)));
  return sets;
}

FrameDescription frame_of(const nb::dict& entries) {
  const Given given(entries, "frame");
  std::string carrier;
  BodyId body;
  Vec3 position;
  Mat3 rotation;
  int32_t node = -1;
  given.read("carrier", carrier);
  given.read("body", body);
  given.read("position", position);
  given.read("node", node);
  const auto numbers = numbers_of<double>(entries["rotation"], "frame rotation", "nine numbers");
  if (numbers.size() != 9) throw InvalidArgument("frame rotation: must have nine numbers");
  std::copy_n(numbers.data(), 9, rotation.m.begin());
  if (carrier == "world") return world_frame(position, rotation);
  if (carrier == "body") return body_frame(body, position, rotation);
  if (carrier == "node") return node_frame(body, node, position, rotation);
  const auto vertices = numbers_of<int32_t>(entries["vertices"], "frame vertices", "three vertex indices");
  if (vertices.size() != 3) throw InvalidArgument("frame vertices: must be three vertex indices");
  return patch_frame(body, {vertices[0], vertices[1], vertices[2]}, position, rotation);
}

}  // namespace

SkinDescription skin_of(const nb::dict& entries, const ShellMaterial& material) {
  auto skin = description_of<SkinDescription>({entries, "skin"});
  skin.material = material;
  return skin;
}

FibresDescription fibres_of(const nb::dict& entries, const RodMaterial& material) {
  auto fibres = description_of<FibresDescription>({entries, "fibres"});
  fibres.material = material;
  const auto all =
      numbers_of<int32_t>(entries["vertices"], "fibres: vertices of paths", "a row of vertex indices");
  auto next = all.begin();
  for (const size_t count : nb::cast<std::vector<size_t>>(entries["counts"])) {
    fibres.paths.emplace_back(next, next + count);
    next += count;
  }
  return fibres;
}

EnergyDescription energy_of(const nb::dict& entries) {
  const Given given = given_of(entries, "energy");
  auto energy = description_of<EnergyDescription>(given);
  energy.potential =
      define_potential(nb::cast<std::string>(entries["formula_name"]), nb::cast<std::string>(entries["doc"]),
                       nb::cast<Formula>(entries["formula"]));
  given.read("translation_invariant", energy.potential.translation_invariant);
  energy.points = point_sets_of(entries["points"]);
  return energy;
}

JointDescription joint_of(const nb::dict& entries) {
  auto joint = description_of<JointDescription>(given_of(entries, "joint"));
  joint.a = frame_of(nb::cast<nb::dict>(entries["a"]));
  joint.b = frame_of(nb::cast<nb::dict>(entries["b"]));
  return joint;
}

ActuatorDescription actuator_of(const nb::dict& entries) {
  auto actuator = description_of<ActuatorDescription>(given_of(entries, "actuator"));
  for (const auto& [joint, coordinate] :
       nb::cast<std::vector<std::pair<JointId, std::string>>>(entries["on"]))
    actuator.on.push_back({joint, coordinate});
  return actuator;
}

AttachmentDescription attachment_of(const nb::dict& entries) {
  const Given given = given_of(entries, "attachment");
  auto attachment = description_of<AttachmentDescription>(given);
  attachment.a = points_of(nb::cast<nb::dict>(entries["a"]));
  attachment.b = point_sets_of(entries["b"]);
  if (const nb::object patches = given.find("patches"))
    attachment.patches = rows_of<Index3, int32_t, 3>(patches, "patches", "an (n, 3) array of vertices");
  return attachment;
}

}  // namespace stark::bindings
