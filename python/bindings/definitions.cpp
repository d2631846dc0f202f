// Bindings of what is registered by name: potentials, one element at a time for tests against other programs
// and for inspection; constitutive laws; joints and actuators. The front ends are stark/materials.py,
// stark/joints and stark/actuators.
#include <stark/mechanics/element_evaluation.h>
#include <stark/sim/registry.h>

#include "given.h"

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

PotentialDefinition linear_element(const SolidLaw& law) { return tet4(law); }
PotentialDefinition linear_element(const ShellLaw& law) { return triangle3(law); }
PotentialDefinition linear_element(const RodLaw& law) { return rod_segment(law); }

/// Checks {name: (numbers, per_element)} against the declarations of the law; other names are not its
/// business.
template <typename Law>
void check_law_values(const Law& law, nb::handle given, const std::string& owner) {
  const ParameterValues values = parameter_values_of(given, owner);
  for (const ParameterDeclaration& declaration : parameters_of(linear_element(law)))
    if (const auto found = values.find(declaration.name); found != values.end())
      check_values(owner, declaration, found->second,
                   static_cast<int64_t>(found->second.values.size()) / declaration.width);
}

template <typename Law>
void bind_law(nb::module_& m, const char* name, const char* doc) {
  m.def(
      "element_formula", [](const Law& law) { return formula_of(linear_element(law)); }, "law"_a,
      "A law on its linear elements: tetrahedra, triangles, segments of rods.");
  nb::class_<Law>(m, name, doc)
      .def_ro("name", &Law::name)
      .def_ro("doc", &Law::doc)
      .def_prop_ro(
          "parameters", [](const Law& law) { return parameters_of(linear_element(law)); },
          "Rows of name, unit, rule, doc, width.")
      .def("check", check_law_values<Law>, "values"_a, "owner"_a,
           "Ranges of {name: (numbers, per_element)}; the number of elements is not known yet.")
      .def("__repr__", [name](const Law& law) {
        return std::string("<stark.materials.") + name + " '" + law.name + "'>";
      });
}

void bind_laws(nb::module_& m) {
  bind_law<SolidLaw>(m, "SolidLaw", "Stored energy of a solid as a formula of the deformation gradient.");
  bind_law<ShellLaw>(m, "ShellLaw", "Stored energy of a membrane as a formula of the deformation gradient.");
  bind_law<RodLaw>(m, "RodLaw", "Stored energy of a rod as a formula of stretch, curvature and twist.");
  m.def("rod_laws", registered_rod_laws, "All built-in laws of rods.");
  m.def("solid_laws", registered_solid_laws, "All built-in laws of solids.");
  m.def("shell_laws", registered_shell_laws, "All built-in laws of membranes that are formulas of F.");
}

nb::list potential_list() {
  return list_of(registered_potentials(), [](const PotentialDefinition& d) {
    return dict_of("name", d.name, "points", d.point_count, "doc", d.doc);
  });
}

std::vector<double> numbers(const nb::dict& values, const ElementInput& field) {
  if (!values.contains(field.name.c_str()))
    throw InvalidArgument("value '" + field.name + "' [" + field.unit + "] is missing: " + field.doc);
  const nb::object value = values[field.name.c_str()];
  if (field.width == 1) return {nb::cast<double>(nb::float_(value))};
  return array_of<double>(value, field.name, std::to_string(field.width) + " numbers");
}

/// Energy [J], gradient [N] (n, 3) and Hessian [N/m] (3n, 3n) of one element.
nb::tuple evaluate_potential(const std::string& name, nb::object x, nb::object rest, nb::object previous,
                             const nb::dict& values) {
  const Potential potential(find_potential(name), symbolic::Backend::Automatic);
  const auto points = [](nb::handle given, const char* as) {
    return array_of<Vec3>(given, as, "an (n, 3) array of positions");
  };
  const std::vector<Vec3> now = points(x, "x");
  ElementEvaluation element =
      evaluate_element(potential, now, rest.is_none() ? now : points(rest, "X"),
                       previous.is_none() ? now : points(previous, "x_prev"),
                       [&](const ElementInput& input) { return numbers(values, input); });
  return nb::make_tuple(element.energy, ArrayOf{element.gradient}, ArrayOf{element.hessian});
}

void bind_potentials(nb::module_& m) {
  m.def("potentials", potential_list, "All registered potentials: name, points, doc.");
  m.def("evaluate_potential", evaluate_potential, "name"_a, "x"_a, "X"_a = nb::none(),
        "x_prev"_a = nb::none(), nb::kw_only(), "values"_a,
        "Energy [J], gradient (n, 3) [N] and Hessian (9 n^2,) [N/m], row by row, of one element of a "
        "registered potential. `values` holds its data and parameters by name; rest and previous positions "
        "default to x.");
}

}  // namespace

void bind_definitions(nb::module_& m) {
  bind_laws(m);
  bind_potentials(m);
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
