// Bindings of actuators: definitions, actuators of scenes. The front end is stark/actuators.
#include "actuators.h"

#include <nanobind/nanobind.h>
#include <nanobind/stl/shared_ptr.h>
#include <nanobind/stl/string.h>
#include <nanobind/stl/vector.h>

#include <stark/sim/registry.h>

namespace stark::bindings {

using namespace nb::literals;

namespace {

using Definition = std::shared_ptr<const ActuatorDefinition>;

/// Rows {name, unit, rule, doc, default} of the values that an actuator has on coordinates of these units.
nb::list parameter_list(const ActuatorDefinition& definition, const std::vector<std::string>& units) {
  nb::list rows;
  for (const ActuatorParameter& parameter : actuator_parameters(definition, units)) {
    nb::dict row;
    row["name"] = parameter.name;
    row["unit"] = parameter.unit;
    row["rule"] = parameter.rule.text();
    row["doc"] = parameter.doc;
    row["default"] = parameter.fallback ? nb::object(nb::float_(*parameter.fallback)) : nb::none();
    rows.append(row);
  }
  return rows;
}

/// defaults: {name: number or None}; one_sided: by row of residuals.
Definition make_actuator(const std::string& name, const std::string& doc, const Formula& formula,
                         int coordinates, const std::vector<bool>& one_sided,
                         const std::vector<std::string>& memories, const nb::dict& defaults) {
  ActuatorOutputs outputs{coordinates, one_sided, memories, {}};
  for (auto [parameter, value] : defaults)
    if (!value.is_none()) outputs.fallbacks[nb::cast<std::string>(parameter)] = nb::cast<double>(value);
  return std::make_shared<const ActuatorDefinition>(define_actuator(name, doc, formula, std::move(outputs)));
}

}  // namespace

int32_t add_actuator(Scene& scene, const nb::dict& given) {
  ActuatorDescription actuator;
  actuator.name = nb::cast<std::string>(given["name"]);
  actuator.definition = nb::cast<Definition>(given["definition"]);
  for (nb::handle row : nb::cast<nb::list>(given["on"])) {
    const auto coordinate = nb::cast<nb::tuple>(row);
    actuator.on.push_back({JointId{nb::cast<int32_t>(coordinate[0])}, nb::cast<std::string>(coordinate[1])});
  }
  for (auto [name, value] : nb::cast<nb::dict>(given["values"]))
    actuator.values[nb::cast<std::string>(name)] = nb::cast<double>(value);
  actuator.enabled = nb::cast<bool>(given["enabled"]);
  return scene.add_actuator(std::move(actuator)).index;
}

}  // namespace stark::bindings

void bind_actuators(nanobind::module_& m) {
  using namespace stark;
  using namespace stark::bindings;
  nb::class_<ActuatorDefinition>(m, "ActuatorDefinition", "An energy of coordinates of joints.")
      .def_ro("name", &ActuatorDefinition::name)
      .def_ro("doc", &ActuatorDefinition::doc)
      .def_ro("coordinate_count", &ActuatorDefinition::coordinate_count)
      .def("parameters", &parameter_list, "units"_a,
           "Values on coordinates of these units: name, unit, rule, doc, default.");
  m.def("make_actuator", &make_actuator, "name"_a, "doc"_a, "formula"_a, "coordinates"_a, "one_sided"_a,
        "memories"_a, "defaults"_a,
        "Actuator of a formula of one point, the changes of the coordinates within a step.");
  m.def("find_actuator", &find_actuator, "name"_a, "A built-in actuator; throws for unknown names.");
  m.def(
      "actuator_names",
      [] {
        nb::list names;
        for (const auto& actuator : registered_actuators()) names.append(actuator->name);
        return names;
      },
      "Names of the built-in actuators.");
}
