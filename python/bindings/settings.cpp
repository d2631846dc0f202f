// Bindings of settings and materials, through their descriptor tables. The Python front ends are
// stark/settings.py and stark/materials.py.
#include <stark/sim/materials.h>
#include <stark/sim/settings.h>

#include "casters.h"
#include "described.h"
#include "domains.h"

namespace {

using namespace stark;
using namespace stark::bindings;

void bind_settings_class(nb::module_& m) {
  bind_described<Settings>(m, "Settings", "All settings of a simulation by dotted name.")
      .def(
          "set_text",
          [](Settings& s, const std::string& name, const std::string& value) {
            set_from_text(s, name, value);
          },
          "name"_a, "text"_a)
      .def(
          "assign",
          [](Settings& s, const std::string& name, nb::handle value) { set(s, name, to_field_value(value)); },
          "name"_a, "value"_a.none(), "As set(), and knows time_step, contact_distance and threads.")
      .def(
          "read", [](const Settings& s, const std::string& name) { return to_python(get(s, name)); },
          "name"_a, "As get(), and knows the short names.")
      .def(
          "validate", [](const Settings& s) { validate(s); }, "Ranges, and the rules between settings.")
      .def("brief", [](const Settings& s) { return changed_from_default(s); });
}

template <typename Material>
nb::list bind_presets(const std::vector<materials::Preset<Material>>& presets) {
  return list_of(presets, [](const auto& p) { return nb::make_tuple(p.name, p.source, p.material); });
}

nb::dict section_to_dict(const RodMaterial& material) {
  const RodSection s = section_of(material);
  return dict_of("mass", s.mass, "axial_stiffness", s.axial_stiffness, "shear_stiffness", s.shear_stiffness,
                 "bending_stiffness_1", s.bending_stiffness[0], "bending_stiffness_2", s.bending_stiffness[1],
                 "torsional_stiffness", s.torsional_stiffness, "yield_force", s.yield_force, "yield_moment_1",
                 s.yield_moments[0], "yield_moment_2", s.yield_moments[1], "yield_torque", s.yield_torque,
                 "yield_hardening", s.yield_hardening);
}

}  // namespace

void bind_settings(nb::module_& m) {
  bind_settings_class(m);
  bind_described<ShellMaterial>(m, "ShellMaterial", "Parameters of cloth and thin shells.");
  bind_described<SolidMaterial>(m, "SolidMaterial", "Parameters of soft solids.");
  bind_described<RodMaterial>(m, "RodMaterial", "Parameters of rods.");
  m.def("rod_section", &section_to_dict, "material"_a, "What the cross-section gives a rod.");
  m.def(
      "rod_presets", [] { return bind_presets(materials::rod_presets()); },
      "(name, source, material) of each.");
  m.def(
      "shell_presets", [] { return bind_presets(materials::shell_presets()); },
      "(name, source, material) of each.");
  m.def(
      "solid_presets", [] { return bind_presets(materials::solid_presets()); },
      "(name, source, material) of each.");
}
