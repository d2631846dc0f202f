// Settings of contact; each is declared in contact_settings.inc.
#pragma once

#include <stark/base/settings.h>

namespace stark {

/// What happens where joints and attachments release bodies that overlap: a caveat of every step until they
/// are apart, or an error.
enum class ReleasedOverlap : uint8_t { Report, Refuse };
template <>
struct EnumNames<ReleasedOverlap> {
  static constexpr std::array<std::string_view, 2> kNames{"report", "refuse"};
};

struct ContactSettings {
#define STARK_SETTING(type, name, value, unit, rule, meaning) type name = value;
#include <stark/contact/contact_settings.inc>
#undef STARK_SETTING
  static const FieldTable& fields();
};

}  // namespace stark
