// Bindings of joints: definitions, frames, joints of scenes and simulations. The front end is stark/joints.
#include <nanobind/nanobind.h>
#include <nanobind/stl/shared_ptr.h>
#include <nanobind/stl/string.h>

#include <stark/sim/registry.h>
#include <stark/sim/simulation.h>

#include "field_values.h"
#include "joints.h"
#include "stepping.h"

namespace stark::bindings {

using namespace nb::literals;

namespace {

using Definition = std::shared_ptr<const JointDefinition>;

ResidualUnit to_unit(const std::string& unit) {
  return unit == "m" ? ResidualUnit::Length : ResidualUnit::Angle;
}

/// holds: [("m" | "rad", count)], coordinates: [(name, unit)], in the order of the outputs of the formula.
Definition make_joint(const std::string& name, const std::string& doc, const Formula& formula,
                      const nb::list& holds, const nb::list& coordinates) {
  JointOutputs outputs;
  for (nb::handle row : holds) {
    const auto hold = nb::cast<nb::tuple>(row);
    outputs.holds.push_back({to_unit(nb::cast<std::string>(hold[0])), nb::cast<int>(hold[1])});
  }
  for (nb::handle row : coordinates) {
    const auto coordinate = nb::cast<nb::tuple>(row);
    outputs.coordinates.push_back(
        {nb::cast<std::string>(coordinate[0]), nb::cast<std::string>(coordinate[1])});
  }
  return std::make_shared<const JointDefinition>(define_joint(name, doc, formula, std::move(outputs)));
}

nb::list coordinate_list(const std::vector<JointOutputs::Coordinate>& coordinates) {
  nb::list rows;
  for (const JointOutputs::Coordinate& c : coordinates) rows.append(nb::make_tuple(c.name, c.unit));
  return rows;
}

Vec3 to_point(nb::handle given, const std::string& name) {
  const auto numbers = array<Column<double>>(given, name, "three numbers");
  if (numbers.shape(0) != 3) throw InvalidArgument(name + ": must have three numbers");
  return {numbers.data()[0], numbers.data()[1], numbers.data()[2]};
}

/// {"carrier": "world" | "body" | "patch" | "node", "body": index, "position", "rotation" (9,),
/// "vertices": (3,), "node": index}
FrameDescription to_frame(const nb::dict& given) {
  const auto carrier = nb::cast<std::string>(given["carrier"]);
  const Vec3 position = to_point(given["position"], "frame position");
  const auto numbers = array<Column<double>>(given["rotation"], "frame rotation", "nine numbers");
  if (numbers.shape(0) != 9) throw InvalidArgument("frame rotation: must have nine numbers");
  Mat3 rotation;
  std::copy_n(numbers.data(), 9, rotation.m.begin());
  if (carrier == "world") return world_frame(position, rotation);
  const BodyId body{nb::cast<int32_t>(given["body"])};
  if (carrier == "body") return body_frame(body, position, rotation);
  if (carrier == "node") return node_frame(body, nb::cast<int32_t>(given["node"]), position, rotation);
  const auto vertices = array<Column<int32_t>>(given["vertices"], "frame vertices", "three vertex indices");
  if (vertices.shape(0) != 3) throw InvalidArgument("frame vertices: must be three vertex indices");
  return patch_frame(body, {vertices.data()[0], vertices.data()[1], vertices.data()[2]}, position, rotation);
}

}  // namespace

int32_t add_joint(Scene& scene, const nb::dict& given) {
  JointDescription joint;
  joint.name = nb::cast<std::string>(given["name"]);
  joint.definition = nb::cast<Definition>(given["definition"]);
  joint.a = to_frame(nb::cast<nb::dict>(given["a"]));
  joint.b = to_frame(nb::cast<nb::dict>(given["b"]));
  joint.values = parameter_values_of(given["values"], "joint '" + joint.name + "'");
  joint.enabled = nb::cast<bool>(given["enabled"]);
  joint.break_force = nb::cast<double>(given["break_force"]);
  joint.break_torque = nb::cast<double>(given["break_torque"]);
  if (given.contains("contact")) joint.contact = nb::cast<bool>(given["contact"]);
  return scene.add_joint(std::move(joint)).index;
}

nb::tuple joint_reaction(const Simulation& simulation, int32_t joint) {
  const Wrench wrench = simulation.joint_reaction({joint});
  const auto column = [](const Vec3& v) { return to_numpy<double>(std::vector<double>{v.x, v.y, v.z}); };
  return nb::make_tuple(column(wrench.force), column(wrench.torque));
}

}  // namespace stark::bindings

void bind_joints(nanobind::module_& m) {
  using namespace stark;
  using namespace stark::bindings;
  nb::class_<JointDefinition>(m, "JointDefinition",
                              "Residuals between two frames that are held, and coordinates.")
      .def_ro("name", &JointDefinition::name)
      .def_ro("doc", &JointDefinition::doc)
      .def_prop_ro(
          "parameters", [](const JointDefinition& d) { return describe(joint_parameters(d)); },
          "Constants to be given: name, unit, rule, doc, width.")
      .def_prop_ro(
          "coordinates", [](const JointDefinition& d) { return coordinate_list(joint_coordinates(d)); },
          "(name, unit) of each coordinate.");
  m.def("make_joint", &make_joint, "name"_a, "doc"_a, "formula"_a, "holds"_a, "coordinates"_a,
        "Joint of a formula of eight points: origin, x, y, z of frame a and of frame b.");
  m.def("find_joint", &find_joint, "name"_a, "A built-in joint; throws for unknown names.");
  m.def(
      "joint_names",
      [] {
        nb::list names;
        for (const auto& joint : registered_joints()) names.append(joint->name);
        return names;
      },
      "Names of the built-in joints.");
}
