// Bindings of settings and materials, through their descriptor tables. The Python front ends are
// stark/settings.py and stark/materials.py.
#include <stark/sim/materials.h>
#include <stark/sim/settings.h>

#include "casters.h"

namespace stark::bindings {

namespace {

/// Rows of what can be set: name, unit, default, rule, choices, doc.
nb::list describe(const FieldTable& table) {
  return list_of(table.fields(), [](const Field& f) {
    return dict_of("name", f.name, "unit", f.unit, "default", f.default_value, "rule", f.rule_text(),
                   "choices", f.choices ? f.choices() : std::vector<std::string>(), "doc", f.doc);
  });
}

/// The methods that every described struct has: get, set, update, to_dict, changed, copy, fields, markdown,
/// ==.
template <typename S>
nb::class_<S> bind_described(nb::module_& m, const char* name, const char* doc) {
  const auto set = [](S& s, const std::string& field, const FieldValue& value, const std::string& owner) {
    S::fields().set(&s, field, value, owner);
  };
  const auto update = [](S& s, const FieldMap& values, const std::string& owner) {
    S::fields().set_all(&s, values, owner);
  };
  return nb::class_<S>(m, name, doc)
      .def(nb::init<>())
      .def(
          "get", [](const S& s, const std::string& field) { return S::fields().get(&s, field); }, "name"_a)
      .def("set", set, "name"_a, "value"_a.none(), "owner"_a = "", "Checks the range, then assigns.")
      .def("update", update, "values"_a, "owner"_a = "", "Assigns all entries, or none when one is refused.")
      .def("to_dict", [](const S& s) { return S::fields().to_map(&s); })
      .def("changed", [](const S& s) { return S::fields().changed_from_default(&s); })
      .def(
          "listing", [](const S& s) { return S::fields().listing(&s); }, "One 'name = value unit' a line.")
      .def("copy", [](const S& s) { return S(s); })
      .def("__eq__", [](const S& s, const S& o) { return S::fields().to_map(&s) == S::fields().to_map(&o); })
      .def_static("fields", [] { return describe(S::fields()); })
      .def_static("markdown", [] { return S::fields().markdown(); });
}

/// A material, and all that come with Stark.
template <typename Material>
void bind_material(nb::module_& m, const char* name, const char* doc, const char* presets,
                   const std::vector<materials::Preset<Material>>& (*all)()) {
  bind_described<Material>(m, name, doc);
  const auto rows = [all] {
    return list_of(all(), [](const auto& p) { return nb::make_tuple(p.name, p.source, p.material); });
  };
  m.def(presets, rows, "(name, source, material) of each.");
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
  bind_described<Settings>(m, "Settings", "All settings of a simulation by dotted name.")
      .def("set_text", &set_from_text, "name"_a, "text"_a)
      .def("assign", &set, "name"_a, "value"_a.none(),
           "As set(), and knows time_step, contact_distance and threads.")
      .def("read", &get, "name"_a, "As get(), and knows the short names.")
      .def("validate", nb::overload_cast<const Settings&>(&validate),
           "Ranges, and the rules between settings.")
      .def("brief", nb::overload_cast<const Settings&>(&changed_from_default));
  bind_material(m, "ShellMaterial", "Parameters of cloth and thin shells.", "shell_presets",
                materials::shell_presets);
  bind_material(m, "SolidMaterial", "Parameters of soft solids.", "solid_presets", materials::solid_presets);
  bind_material(m, "RodMaterial", "Parameters of rods.", "rod_presets", materials::rod_presets);
  m.def("rod_section", &section_to_dict, "material"_a, "What the cross-section gives a rod.");
}

}  // namespace stark::bindings
