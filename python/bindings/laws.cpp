// Bindings of the constitutive laws: names, parameters, checks of values.
#include <stark/sim/registry.h>

#include "given.h"

namespace stark::bindings {

namespace {

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

}  // namespace

void bind_laws(nb::module_& m) {
  bind_law<SolidLaw>(m, "SolidLaw", "Stored energy of a solid as a formula of the deformation gradient.");
  bind_law<ShellLaw>(m, "ShellLaw", "Stored energy of a membrane as a formula of the deformation gradient.");
  bind_law<RodLaw>(m, "RodLaw", "Stored energy of a rod as a formula of stretch, curvature and twist.");
  m.def("rod_laws", registered_rod_laws, "All built-in laws of rods.");
  m.def("solid_laws", registered_solid_laws, "All built-in laws of solids.");
  m.def("shell_laws", registered_shell_laws, "All built-in laws of membranes that are formulas of F.");
}

}  // namespace stark::bindings
