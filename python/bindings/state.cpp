// Bindings of states: values that are compared, copied and taken apart into arrays.
#include <stark/base/hash.h>
#include <stark/base/settings.h>
#include <stark/mechanics/state.h>

#include "functions.h"

namespace stark::bindings {

namespace {

/// A field as an array of its own.
nb::object copied(const StateArray& field) {
  size_t count = 1;
  for (const size_t extent : field.shape) count *= extent;
  const auto copy = [&]<typename T>(const T* data) {
    return nb::cast(to_numpy(std::vector<T>(data, data + count), field.shape));
  };
  return field.is_integer ? copy(static_cast<const int64_t*>(field.data))
                          : copy(static_cast<const double*>(field.data));
}

nb::dict state_arrays(const State& state) {
  nb::dict arrays;
  for (const StateArray& field : arrays_of(state)) arrays[field.name.c_str()] = copied(field);
  return arrays;
}

State state_of_arrays(const nb::dict& given) {
  using Any = nb::ndarray<nb::ro, nb::c_contig, nb::device::cpu>;
  std::vector<Any> kept;  // the arrays live as long as they are read
  std::vector<StateArray> arrays;
  for (const auto& [key, value] : given) {
    const std::string name = text(key);
    Any array;
    if (!is_such_array(value, array) ||
        (array.dtype() != nb::dtype<double>() && array.dtype() != nb::dtype<int64_t>()))
      throw InvalidArgument("state: the field '" + name +
                            "' must be a contiguous array of the type float64 or int64");
    StateArray field{.name = name, .unit = "", .meaning = ""};
    field.is_integer = array.dtype() == nb::dtype<int64_t>();
    for (size_t k = 0; k < array.ndim(); ++k) field.shape.push_back(array.shape(k));
    field.data = array.data();
    kept.push_back(array);
    arrays.push_back(field);
  }
  return make_state(arrays);
}

}  // namespace

void bind_state(nb::module_& m) {
  using S = State;
  nb::class_<S> state(m, "State", "Everything that changes in time, as a value.");
  property(state, "time", &S::time, "Simulated time [s].");
  property(state, "time_step", &S::time_step, "Length of the next step, or less for the next mark [s].");
  property(state, "step_count", &S::step_count, "Accepted steps so far.");
  property(state, "point_positions", &S::point_position, "Points of cloth and solids (n, 3) [m].");
  property(state, "point_velocities", &S::point_velocity, "Their velocities (n, 3) [m/s].");
  property(state, "body_positions", &S::body_position, "Centres of mass, nodes of rods (n, 3) [m].");
  property(
      state, "hash", [](const S& s) { return to_hex(s.hash()); }, "Hash of all bits, 16 hexadecimal digits.");
  def(state, "copy", [](const S& s) { return s; }, "A state of its own: the same value.");
  def(state, "arrays", state_arrays, "All fields by name, as arrays of their own: see State.fields().");
  state.def_static("of_arrays", state_of_arrays, "arrays"_a,
                   "The state of what arrays() gave. Raises InvalidArgument for fields that are missing, "
                   "unknown or of another type or shape.");
  state.def_static("fields", [] { return arrays_of(S()); }, "Name, unit and meaning of each, in order.");
  def(state, "first_difference", first_difference, {"other"},
      "Name of the first field that differs, '' when all bits are equal.");
  state.def(
      "__eq__", [](const S& a, const S& b) { return first_difference(a, b).empty(); }, "other"_a,
      nb::is_operator());
  def(state, "__repr__", [](const S& s) {
    return "<stark.State at " + to_text(s.time) + " s, after " + std::to_string(s.step_count) + " steps>";
  });
  def(state, "__hash__", [](const S& s) { return static_cast<Py_hash_t>(s.hash() >> 1); });
}

}  // namespace stark::bindings
