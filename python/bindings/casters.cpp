#include "casters.h"

namespace stark::bindings {

nb::object to_python(const FieldValue& value) {
  if (const auto* v = std::get_if<Vec3>(&value)) return nb::make_tuple(v->x, v->y, v->z);
  if (const auto* flag = std::get_if<bool>(&value)) return nb::bool_(*flag);
  if (const auto* integer = std::get_if<int64_t>(&value)) return nb::int_(*integer);
  if (const auto* real = std::get_if<double>(&value)) return nb::float_(*real);
  return nb::str(std::get<std::string>(value).c_str());
}

FieldValue to_field_value(nb::handle object) {
  if (nb::isinstance<nb::str>(object)) return nb::cast<std::string>(object);
  if (nb::isinstance<nb::bool_>(object)) return nb::cast<bool>(object);
  if (PyIndex_Check(object.ptr()) && !nb::hasattr(object, "__len__")) {
    int64_t integer = 0;
    if (nb::try_cast<int64_t>(nb::int_(object), integer)) return integer;
  }
  try {
    if (nb::hasattr(object, "__len__")) {
      if (nb::len(object) == 3) {
        Vec3 v;
        for (int i = 0; i < 3; ++i) v[i] = nb::cast<double>(nb::float_(object[i]));
        return v;
      }
    } else if (nb::hasattr(object, "__float__")) {
      return nb::cast<double>(nb::float_(object));
    }
  } catch (const std::exception&) {
  }
  return text(object);
}

}  // namespace stark::bindings
