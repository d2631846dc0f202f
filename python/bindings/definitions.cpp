// Bindings of the definitions of joints and actuators. The front ends are stark/joints and stark/actuators.
#include <nanobind/nanobind.h>
#include <nanobind/stl/optional.h>
#include <nanobind/stl/pair.h>
#include <nanobind/stl/shared_ptr.h>
#include <nanobind/stl/string.h>
#include <nanobind/stl/vector.h>

#include <stark/sim/registry.h>

#include "domains.h"
#include "given.h"

namespace {

namespace nb = nanobind;
using namespace nb::literals;
using namespace stark;
using namespace stark::bindings;

using Joint = std::shared_ptr<const JointDefinition>;
using Actuator = std::shared_ptr<const ActuatorDefinition>;

/// holds: [("m" | "rad", count)], coordinates: [(name, unit)], in the order of the outputs of the formula.
Joint make_joint(const std::string& name, const std::string& doc, const Formula& formula,
                 const nb::list& holds, const nb::list& coordinates) {
  JointOutputs outputs;
  for (const auto& [unit, count] : nb::cast<std::vector<std::pair<std::string, int>>>(holds))
    outputs.holds.push_back({unit == "m" ? ResidualUnit::Length : ResidualUnit::Angle, count});
  for (const auto& [coordinate, unit] :
       nb::cast<std::vector<std::pair<std::string, std::string>>>(coordinates))
    outputs.coordinates.push_back({coordinate, unit});
  return std::make_shared<const JointDefinition>(define_joint(name, doc, formula, std::move(outputs)));
}

/// defaults: {name: number or None}; one_sided: by row of residuals.
Actuator make_actuator(const std::string& name, const std::string& doc, const Formula& formula,
                       int coordinates, const std::vector<bool>& one_sided,
                       const std::vector<std::string>& memories, const nb::dict& defaults) {
  ActuatorOutputs outputs{coordinates, one_sided, memories, {}};
  for (const auto& [parameter, value] : nb::cast<std::map<std::string, std::optional<double>>>(defaults))
    if (value) outputs.fallbacks[parameter] = *value;
  return std::make_shared<const ActuatorDefinition>(define_actuator(name, doc, formula, std::move(outputs)));
}

/// Rows {name, unit, rule, doc, default} of the values that an actuator has on coordinates of these units.
nb::list actuator_parameter_list(const ActuatorDefinition& definition,
                                 const std::vector<std::string>& units) {
  return list_of(actuator_parameters(definition, units), [](const ActuatorParameter& p) {
    return dict_of("name", p.name, "unit", p.unit, "rule", p.rule.text(), "doc", p.doc, "default",
                   p.fallback);
  });
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
      .def_prop_ro(
          "parameters", [](const JointDefinition& d) { return describe(joint_parameters(d)); },
          "Constants to be given: name, unit, rule, doc, width.")
      .def_prop_ro(
          "coordinates",
          [](const JointDefinition& d) {
            return list_of(joint_coordinates(d),
                           [](const auto& c) { return nb::make_tuple(c.name, c.unit); });
          },
          "(name, unit) of each coordinate.");
  m.def("make_joint", &make_joint, "name"_a, "doc"_a, "formula"_a, "holds"_a, "coordinates"_a,
        "Joint of a formula of eight points: origin, x, y, z of frame a and of frame b.");
  m.def("find_joint", &find_joint, "name"_a, "A built-in joint; throws for unknown names.");
  m.def("joint_names", [] { return names_of(registered_joints()); }, "Names of the built-in joints.");
  nb::class_<ActuatorDefinition>(m, "ActuatorDefinition", "An energy of coordinates of joints.")
      .def_ro("name", &ActuatorDefinition::name)
      .def_ro("doc", &ActuatorDefinition::doc)
      .def_ro("coordinate_count", &ActuatorDefinition::coordinate_count)
      .def("parameters", &actuator_parameter_list, "units"_a,
           "Values on coordinates of these units: name, unit, rule, doc, default.");
  m.def("make_actuator", &make_actuator, "name"_a, "doc"_a, "formula"_a, "coordinates"_a, "one_sided"_a,
        "memories"_a, "defaults"_a,
        "Actuator of a formula of one point, the changes of the coordinates within a step.");
  m.def("find_actuator", &find_actuator, "name"_a, "A built-in actuator; throws for unknown names.");
  m.def(
      "actuator_names", [] { return names_of(registered_actuators()); }, "Names of the built-in actuators.");
}
