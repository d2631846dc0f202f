// Bindings of what is registered by name: potentials, constitutive laws, joints and actuators. The front ends
// are stark/materials.py, stark/joints and stark/actuators.
#include <stark/mechanics/law_elements.h>
#include <stark/sim/scene/registry.h>

#include "functions.h"

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

template <typename Law>
auto parameters(const Law& law) {
  return parameters_of(linear_element(law));
}
template <typename Law>
Formula element_formula(const Law& law) {
  return formula_of(linear_element(law));
}
template <typename Law>
void check(const Law& law, nb::handle values, const std::string& owner) {
  check_law_values(owner, law, parameter_values_of(values, owner));
}

template <typename Law>
void bind_law(nb::module_& m, const char* name, const char* doc) {
  def<element_formula<Law>>(m, {"law"});
  nb::class_<Law> c(m, name, doc);
  property(c, "name", &Law::name);
  property(c, "doc", &Law::doc);
  property(c, "parameters", parameters<Law>, "Rows of name, unit, rule, doc, width.");
  def(c, "check", check<Law>, {"values", "owner"},
      "Ranges of {name: (numbers, per_element)}; the number of elements is not known yet.");
  def(c, "__repr__", [title = std::string("<stark.materials.") + name](const Law& law) {
    return title + " '" + law.name + "'>";
  });
}

void bind_laws(nb::module_& m) {
  bind_law<SolidLaw>(m, "SolidLaw", "Stored energy of a solid as a formula of the deformation gradient.");
  bind_law<ShellLaw>(m, "ShellLaw", "Stored energy of a membrane as a formula of the deformation gradient.");
  bind_law<RodLaw>(m, "RodLaw", "Stored energy of a rod as a formula of stretch, curvature and twist.");
  def(m, "rod_laws", registered_rod_laws, "All built-in laws of rods.");
  def(m, "solid_laws", registered_solid_laws, "All built-in laws of solids.");
  def(m, "shell_laws", registered_shell_laws, "All built-in laws of membranes that are formulas of F.");
}

void bind_joints(nb::module_& m) {
  using J = JointDefinition;
  nb::class_<J> joint(m, "JointDefinition", "Residuals between two frames that are held, and coordinates.");
  property<&J::name, &J::doc>(joint);
  property(joint, "parameters", joint_parameters, "Constants to be given: name, unit, rule, doc, width.");
  property(joint, "coordinates", joint_coordinates, "(name, unit) of each coordinate.");
  def(m, "make_joint", make_joint, {"name", "doc", "formula", "holds", "coordinates"},
      "Joint of a formula of eight points: origin, x, y, z of frame a and of frame b.");
  def(m, "find_joint", find_joint, {"name"}, "A built-in joint; throws for unknown names.");
  def(m, "joint_names", [] { return names_of(registered_joints()); }, "Names of the built-in joints.");
}

void bind_actuators(nb::module_& m) {
  using A = ActuatorDefinition;
  nb::class_<A> actuator(m, "ActuatorDefinition", "An energy of coordinates of joints.");
  property<&A::name, &A::doc, &A::coordinate_count>(actuator);
  def(actuator, "parameters", actuator_parameters, {"units"},
      "Values on coordinates of these units: name, unit, rule, doc, default.");
  def(m, "make_actuator", make_actuator,
      {"name", "doc", "formula", "coordinates", "one_sided", "memories", "defaults"},
      "Actuator of a formula of one point, the changes of the coordinates within a step.");
  def(m, "find_actuator", find_actuator, {"name"}, "A built-in actuator; throws for unknown names.");
  def(
      m, "actuator_names", [] { return names_of(registered_actuators()); },
      "Names of the built-in actuators.");
}

}  // namespace

void bind_definitions(nb::module_& m) {
  bind_laws(m);
  bind_joints(m);
  bind_actuators(m);
  def(m, "potentials", registered_potentials, "All registered potentials: name, points, doc.");
}

}  // namespace stark::bindings
