// Bindings of settings and materials, through their descriptor tables. The Python front ends are
// stark/settings.py and stark/materials.py.
#include <stark/sim/scene/materials.h>
#include <stark/sim/scene/settings.h>

#include "functions.h"

namespace stark::bindings {

namespace {

/// The methods that every described struct has.
template <typename S>
nb::class_<S> bind_described(nb::module_& m, const char* name, const char* doc) {
  const auto set = [](S& s, const std::string& field, const FieldValue& value, const std::string& owner) {
    S::fields().set(&s, field, value, owner);
  };
  const auto update = [](S& s, const FieldMap& values, const std::string& owner) {
    S::fields().set_all(&s, values, owner);
  };
  nb::class_<S> c(m, name, doc);
  c.def(nb::init<>());
  def(c, "get", [](const S& s, const std::string& field) { return S::fields().get(&s, field); }, {"name"});
  c.def("set", set, "name"_a, "value"_a.none(), "owner"_a = "", "Checks the range, then assigns.");
  def(c, "update", update, {"values", {"owner", ""}}, "Assigns all entries, or none when one is refused.");
  def(c, "to_dict", [](const S& s) { return S::fields().to_map(&s); });
  def(c, "changed", [](const S& s) { return S::fields().changed_from_default(&s); });
  def(c, "listing", [](const S& s) { return S::fields().listing(&s); }, "One 'name = value unit' a line.");
  def(c, "copy", [](const S& s) { return S(s); });
  def(c, "__eq__", [](const S& s, const S& o) { return S::fields().to_map(&s) == S::fields().to_map(&o); },
      {"other"});
  c.def_static("fields", [] { return S::fields().fields(); });
  c.def_static("markdown", [] { return S::fields().markdown(); });
  return c;
}

/// A material, and all that come with Stark.
template <typename Material>
void bind_material(nb::module_& m, const char* name, const char* doc, const char* presets,
                   const std::vector<materials::Preset<Material>>& (*all)()) {
  bind_described<Material>(m, name, doc);
  const auto rows = [all] {
    return list_of(all(), [](const auto& p) { return nb::make_tuple(p.name, p.source, p.material); });
  };
  def(m, presets, rows, "(name, source, material) of each.");
}

}  // namespace

void bind_settings(nb::module_& m) {
  auto settings = bind_described<Settings>(m, "Settings", "All settings of a simulation by dotted name.");
  def(settings, "set_text", set_from_text, {"name", "text"});
  settings.def("assign", set, "name"_a, "value"_a.none(), "As set(), and knows short names.");
  def(settings, "read", get, {"name"}, "As get(), and knows the short names.");
  def(settings, "validate", nb::overload_cast<const Settings&>(&validate));
  def(settings, "brief", nb::overload_cast<const Settings&>(&changed_from_default));
  bind_material(m, "ShellMaterial", "Parameters of cloth and thin shells.", "shell_presets",
                materials::shell_presets);
  bind_material(m, "SolidMaterial", "Parameters of soft solids.", "solid_presets", materials::solid_presets);
  bind_material(m, "RodMaterial", "Parameters of rods.", "rod_presets", materials::rod_presets);
  def(m, "rod_section", section_of, {"material"});
}

}  // namespace stark::bindings
