// Bindings of the definitions of joints and actuators. The front ends are stark/joints and stark/actuators.
#include <stark/sim/registry.h>

#include "casters.h"

namespace stark::bindings {

namespace {

using Joint = std::shared_ptr<const JointDefinition>;
using Pairs = std::vector<std::pair<std::string, std::string>>;
using Actuator = std::shared_ptr<const ActuatorDefinition>;

/// holds: [("m" | "rad", count)], coordinates: [(name, unit)], in the order of the outputs of the formula.
Joint make_joint(const std::string& name, const std::string& doc, const Formula& formula,
                 const std::vector<std::pair<std::string, int>>& holds, const Pairs& coordinates) {
  JointOutputs outputs;
  for (const auto& [unit, count] : holds)
    outputs.holds.push_back({unit == "m" ? ResidualUnit::Length : ResidualUnit::Angle, count});
  for (const auto& [coordinate, unit] : coordinates) outputs.coordinates.push_back({coordinate, unit});
  return std::make_shared<const JointDefinition>(define_joint(name, doc, formula, std::move(outputs)));
}

/// defaults: {name: number or None}; one_sided: by row of residuals.
Actuator make_actuator(const std::string& name, const std::string& doc, const Formula& formula,
                       int coordinates, const std::vector<bool>& one_sided,
                       const std::vector<std::string>& memories,
                       const std::map<std::string, std::optional<double>>& defaults) {
  ActuatorOutputs outputs{coordinates, one_sided, memories, {}};
  for (const auto& [parameter, value] : defaults)
    if (value) outputs.fallbacks[parameter] = *value;
  return std::make_shared<const ActuatorDefinition>(define_actuator(name, doc, formula, std::move(outputs)));
}

template <typename Definitions>
nb::list names_of(const Definitions& definitions) {
  return list_of(definitions, [](const auto& definition) { return definition->name; });
}

}  // namespace

void bind_definitions(nb::module_& m) {
  nb::class_<JointDefinition>(m, "JointDefinition",
                              "Residuals between two frames that are held, and coordinates.")
      .def_ro("name", &JointDefinition::name)
      .def_ro("doc", &JointDefinition::doc)
      .def_prop_ro("parameters", &joint_parameters, "Constants to be given: name, unit, rule, doc, width.")
      .def_prop_ro("coordinates", &joint_coordinates, "(name, unit) of each coordinate.");
  m.def("make_joint", &make_joint, "name"_a, "doc"_a, "formula"_a, "holds"_a, "coordinates"_a,
        "Joint of a formula of eight points: origin, x, y, z of frame a and of frame b.");
  m.def("find_joint", &find_joint, "name"_a, "A built-in joint; throws for unknown names.");
  m.def("joint_names", [] { return names_of(registered_joints()); }, "Names of the built-in joints.");
  nb::class_<ActuatorDefinition>(m, "ActuatorDefinition", "An energy of coordinates of joints.")
      .def_ro("name", &ActuatorDefinition::name)
      .def_ro("doc", &ActuatorDefinition::doc)
      .def_ro("coordinate_count", &ActuatorDefinition::coordinate_count)
      .def("parameters", &actuator_parameters, "units"_a,
           "Values on coordinates of these units: name, unit, rule, doc, default.");
  m.def("make_actuator", &make_actuator, "name"_a, "doc"_a, "formula"_a, "coordinates"_a, "one_sided"_a,
        "memories"_a, "defaults"_a,
        "Actuator of a formula of one point, the changes of the coordinates within a step.");
  m.def("find_actuator", &find_actuator, "name"_a, "A built-in actuator; throws for unknown names.");
  m.def(
      "actuator_names", [] { return names_of(registered_actuators()); }, "Names of the built-in actuators.");
}

}  // namespace stark::bindings
