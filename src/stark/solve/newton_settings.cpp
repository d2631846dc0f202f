#include <stark/solve/newton_settings.h>

#include <numbers>

namespace stark {

const FieldTable& NewtonSettings::fields() {
  static const FieldTable table("newton", TableKind::Settings,
                                {
#define STARK_SETTING(type, name, value, unit, rule, meaning) \
  field(&NewtonSettings::name, #name, unit, rule, meaning),
#include <stark/solve/newton_settings.inc>
#undef STARK_SETTING
                                });
  return table;
}

}  // namespace stark
