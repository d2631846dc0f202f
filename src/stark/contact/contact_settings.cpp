#include <stark/contact/contact_settings.h>

namespace stark {

const FieldTable& ContactSettings::fields() {
  static const FieldTable table("contact", TableKind::Settings,
                                {
#define STARK_SETTING(type, name, value, unit, rule, meaning) \
  field(&ContactSettings::name, #name, unit, rule, meaning),
#include <stark/contact/contact_settings.inc>
#undef STARK_SETTING
                                });
  return table;
}

}  // namespace stark
