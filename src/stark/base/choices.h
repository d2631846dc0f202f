// Enumerators by the names that users write.
#pragma once

#include <stark/base/error.h>
#include <stark/base/settings.h>

namespace stark {

/// The enumerator of a name; throws InvalidArgument about the subject that lists all of them.
template <typename Choice>
Choice choice_of(const std::string& value, const std::string& subject) {
  const auto& names = EnumNames<Choice>::kNames;
  const std::vector<std::string> known(names.begin(), names.end());
  std::string list;
  for (size_t i = 0; i < known.size(); ++i) {
    if (known[i] == value) return static_cast<Choice>(i);
    list += (i ? ", '" : "'") + known[i] + "'";
  }
  throw InvalidArgument(subject + ": must be one of " + list + nearest_name_hint(value, known));
}

}  // namespace stark
