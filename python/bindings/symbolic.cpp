// Bindings of the expression graph: traced scalars with the operators and functions of Python. Formulas are
// built by running Python code on traced scalars, so whatever would need their values raises TraceError.
#include "symbolic.h"

#include <nanobind/stl/optional.h>
#include <nanobind/stl/string.h>

#include <stark/base/error.h>
#include <stark/symbolic/evaluate.h>
#include <stark/symbolic/named_functions.h>

#include "arrays.h"

namespace stark::bindings {

using namespace nb::literals;
using symbolic::BinaryOperator;
using symbolic::Scalar;
using symbolic::UnaryOperation;

std::optional<TracedScalar> to_traced(nb::handle object) {
  TracedScalar* traced = nullptr;
  if (nb::try_cast(object, traced, false)) return *traced;
  // NumPy's scalars and arrays without dimensions have a shape; arrays with dimensions are not scalars.
  const bool number = PyFloat_Check(object.ptr()) || PyLong_Check(object.ptr());
  if (!number) {
    if (!nb::hasattr(object, "dtype") || !nb::hasattr(object, "ndim")) return std::nullopt;
    if (nb::cast<int>(object.attr("ndim")) != 0) return std::nullopt;
    const std::string kind = text(object.attr("dtype").attr("kind"));
    if (kind == "O") return to_traced(object.attr("item")());
    if (std::string("biuf").find(kind) == std::string::npos) return std::nullopt;
  }
  const double value = PyFloat_AsDouble(object.ptr());
  if (value == -1.0 && PyErr_Occurred()) throw nb::python_error();
  return TracedScalar{nullptr, Scalar(value)};
}

TracedScalar require_traced(nb::handle object, const std::string& name) {
  if (auto traced = to_traced(object)) return *traced;
  throw TraceError(name + ": got " + text(object.type().attr("__name__")) + ": must be a scalar or a number");
}

std::vector<TracedScalar> require_traced_list(nb::handle sequence, const std::string& name) {
  std::vector<TracedScalar> result;
  for (const nb::handle item : sequence)
    result.push_back(require_traced(item, name + "[" + std::to_string(result.size()) + "]"));
  return result;
}

namespace {

const char* const kNoBranches =
    "a formula is recorded once and then run for many inputs, so its values cannot steer Python code: write "
    "stark.where(condition, a, b) for if, `&`, `|`, `~` for and, or, not, and stark.minimum, stark.maximum "
    "for min, max; write both bounds of a < x < b with `&`";

// Operators.

/// bool becomes a condition where one is meant.
std::optional<TracedScalar> to_condition(nb::handle object) {
  if (PyBool_Check(object.ptr()) || (nb::hasattr(object, "dtype") && text(object.attr("dtype")) == "bool"))
    return TracedScalar{nullptr, Scalar::literal_condition(nb::cast<bool>(nb::bool_(object)))};
  return to_traced(object);
}

/// The operator of Python, with the scalar on the left or on the right; other types get their turn by
/// NotImplemented.
nb::object operate(const BinaryOperator& op, const TracedScalar& self, nb::handle other, bool on_the_right) {
  const auto operand = op.of_conditions ? to_condition(other) : to_traced(other);
  if (!operand) return nb::borrow(Py_NotImplemented);
  return nb::cast(apply(op.function, on_the_right ? *operand : self, on_the_right ? self : *operand,
                        op.of_conditions, op.symbol));
}

nb::object python_power(const TracedScalar& a, nb::handle exponent) {
  if (PyLong_Check(exponent.ptr())) {
    const long long n = PyLong_AsLongLong(exponent.ptr());
    if (n == -1 && PyErr_Occurred()) throw nb::python_error();
    return nb::cast(symbolic::power(a, n));
  }
  return operate(symbolic::kPower, a, exponent, false);
}

std::string representation(const TracedScalar& x) { return "Scalar(" + to_string(x.value, 200) + ")"; }

double constant_value(const TracedScalar& x, const char* conversion) {
  if (x.value.is_constant() && !x.value.is_condition()) return x.value.value();
  throw TraceError(std::string(conversion) + " of the traced value " + short_text(x) +
                   ": a formula is recorded once and then run for many inputs, so its values are not numbers "
                   "yet; use the functions of stark (stark.sqrt, stark.sin, ...) instead of those of math, "
                   "and only fixed numbers as indices, lengths and counts");
}

bool constant_truth(const TracedScalar& x) {
  if (x.value.is_constant()) return x.value.value() != 0.0;
  throw TraceError("the truth of the traced value " + short_text(x) + " was asked for (if, while, and, or, " +
                   "not, min, max, sorted): " + kNoBranches);
}

[[noreturn]] void no_equality(const TracedScalar& x, nb::handle) {
  throw TraceError("== or != of the traced value " + short_text(x) +
                   ": equality of computed numbers is not part of formulas; compare with <= and >=, or use "
                   "stark.symbolic.is_same(a, b) to ask whether two expressions are the same");
}

[[noreturn]] void no_such_operator(const TracedScalar& x, nb::handle) {
  throw TraceError("// and % of the traced value " + short_text(x) +
                   ": rounding has no derivative and is not part of formulas");
}

// Functions.

TracedScalar where(nb::handle condition, nb::handle a, nb::handle b) {
  auto c = to_condition(condition);
  if (!c) c = require_traced(condition, "where: the condition");
  return symbolic::where(*c, require_traced(a, "where"), require_traced(b, "where"));
}

void bind_operators(nb::class_<TracedScalar>& c) {
  const auto on = [&c](const char* name, const BinaryOperator& op, bool on_the_right = false) {
    c.def(
        name,
        [&op, on_the_right](const TracedScalar& self, nb::handle other) {
          return operate(op, self, other, on_the_right);
        },
        nb::is_operator());
  };
  const auto both = [&on](const char* left, const char* right, const BinaryOperator& op) {
    on(left, op);
    on(right, op, true);
  };
  both("__add__", "__radd__", symbolic::kAdd);
  both("__sub__", "__rsub__", symbolic::kSubtract);
  both("__mul__", "__rmul__", symbolic::kMultiply);
  both("__truediv__", "__rtruediv__", symbolic::kDivide);
  both("__and__", "__rand__", symbolic::kAnd);
  both("__or__", "__ror__", symbolic::kOr);
  both("__xor__", "__rxor__", symbolic::kXor);
  on("__lt__", symbolic::kLess);
  on("__le__", symbolic::kLessEqual);
  on("__gt__", symbolic::kGreater);
  on("__ge__", symbolic::kGreaterEqual);
  c.def("__pow__", python_power, nb::is_operator());
  on("__rpow__", symbolic::kPower, true);
  c.def("__invert__", [](const TracedScalar& a) {
    require_kind(a, true, "~");
    return TracedScalar{a.graph, !a.value};
  });
  c.def("__neg__", [](const TracedScalar& a) {
    return apply(static_cast<UnaryOperation>(symbolic::operator-), a, "-");
  });
  c.def("__pos__", [](const TracedScalar& a) { return a; });
  c.def("__abs__", [](const TracedScalar& a) { return apply(symbolic::abs, a, "abs"); });
  c.def("__eq__", no_equality, "other"_a.none());
  c.def("__ne__", no_equality, "other"_a.none());
  c.def("__hash__", [](nb::handle self) { return reinterpret_cast<Py_ssize_t>(self.ptr()) >> 4; });
  for (const char* name : {"__mod__", "__rmod__", "__floordiv__", "__rfloordiv__"})
    c.def(name, no_such_operator);
  c.def("__bool__", constant_truth);
  c.def("__float__", [](const TracedScalar& x) { return constant_value(x, "float()"); });
  c.def("__int__", [](const TracedScalar& x) { return static_cast<long long>(constant_value(x, "int()")); });
  c.def("__index__", [](const TracedScalar& x) -> long long {
    throw TraceError("the traced value " + short_text(x) +
                     " was used as an index or a count; only fixed integers can be");
  });
  c.def("__repr__", representation);
}

void bind_functions(nb::module_& m) {
  for (const symbolic::NamedUnary& f : symbolic::kUnaryFunctions)
    m.def(
        f.name, [f](nb::handle x) { return apply(f.function, require_traced(x, f.name), f.name); }, "x"_a,
        f.doc);
  const auto binary = [&m](const char* name, symbolic::BinaryOperation function, const char* first,
                           const char* second, const char* doc) {
    m.def(
        name,
        [function, name](nb::handle a, nb::handle b) {
          return apply(function, require_traced(a, name), require_traced(b, name), false, name);
        },
        nb::arg(first), nb::arg(second), doc);
  };
  binary("minimum", symbolic::min, "a", "b", "a < b ? a : b.");
  binary("maximum", symbolic::max, "a", "b", "a > b ? a : b.");
  binary("atan2", symbolic::atan2, "y", "x", "Angle [rad] of the direction (x, y).");
  m.def(
      "pow", [](nb::handle a, nb::handle b) { return python_power(require_traced(a, "pow"), b); }, "base"_a,
      "exponent"_a, "Power: products for integer exponents, else the real power of a base >= 0.");
  m.def("where", where, "condition"_a, "a"_a, "b"_a,
        "a where the condition holds, else b. The other branch never contributes, not even as NaN.");
  m.def(
      "fma",
      [](nb::handle a, nb::handle b, nb::handle c) {
        return symbolic::fused_multiply_add(require_traced(a, "fma"), require_traced(b, "fma"),
                                            require_traced(c, "fma"));
      },
      "a"_a, "b"_a, "c"_a, "a b + c with one rounding.");
  m.def(
      "is_same",
      [](const TracedScalar& a, const TracedScalar& b) { return symbolic::is_same(a.value, b.value); }, "a"_a,
      "b"_a, "Whether two scalars are the same expression.");
  m.def(
      "constant", [](nb::handle x) { return require_traced(x, "constant"); }, "x"_a,
      "The scalar that stands for a number; scalars are returned as they are.");
  m.def(
      "is_scalar_like", [](nb::handle x) { return to_traced(x).has_value(); }, "x"_a.none(),
      "Whether the value is a scalar or a number.");
}

}  // namespace
}  // namespace stark::bindings

void bind_symbolic(nanobind::module_& parent) {
  using namespace stark::bindings;
  nb::module_ m = parent.def_submodule("symbolic", "Expression graphs, derivatives, machine code.");
  bind_graph(m);
  nb::class_<TracedScalar> scalar(m, "Scalar", "A number of a formula: recorded, not computed.");
  bind_operators(scalar);
  bind_nodes(scalar);
  bind_functions(m);
  bind_array_functions(m);
}
