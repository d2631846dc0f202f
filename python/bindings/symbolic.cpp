// Bindings of the expression graph: traced scalars with the operators and functions of Python. Formulas are
// built by running Python code on traced scalars, so whatever would need their values raises TraceError.
#include "symbolic.h"

#include <nanobind/stl/optional.h>
#include <nanobind/stl/string.h>

#include <stark/base/error.h>
#include <stark/symbolic/evaluate.h>

#include "arrays.h"

namespace stark::bindings {

using namespace nb::literals;
using symbolic::Scalar;

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

/// The operator of Python; other types get their turn by NotImplemented.
template <bool Swap, bool Conditions = false>
auto python_operator(symbolic::BinaryOperation function, const char* operation) {
  return [function, operation](const TracedScalar& a, nb::handle other) -> nb::object {
    const auto b = Conditions ? to_condition(other) : to_traced(other);
    if (!b) return nb::borrow(Py_NotImplemented);
    return nb::cast(Swap ? apply(function, *b, a, Conditions, operation)
                         : apply(function, a, *b, Conditions, operation));
  };
}

Scalar add(const Scalar& a, const Scalar& b) { return a + b; }
Scalar subtract(const Scalar& a, const Scalar& b) { return a - b; }
Scalar multiply(const Scalar& a, const Scalar& b) { return a * b; }
Scalar divide(const Scalar& a, const Scalar& b) { return a / b; }
Scalar less(const Scalar& a, const Scalar& b) { return a < b; }
Scalar less_equal(const Scalar& a, const Scalar& b) { return a <= b; }
Scalar greater(const Scalar& a, const Scalar& b) { return a > b; }
Scalar greater_equal(const Scalar& a, const Scalar& b) { return a >= b; }
Scalar both(const Scalar& a, const Scalar& b) { return a && b; }
Scalar either(const Scalar& a, const Scalar& b) { return a || b; }
Scalar differ(const Scalar& a, const Scalar& b) { return (a && !b) || (!a && b); }
Scalar negative(const Scalar& a) { return -a; }

/// Integer exponents are products, other numbers real powers of a base >= 0.
Scalar power(const Scalar& a, const Scalar& b) { return symbolic::pow(a, b); }

nb::object python_power(const TracedScalar& a, nb::handle exponent) {
  if (PyLong_Check(exponent.ptr())) {
    const long long n = PyLong_AsLongLong(exponent.ptr());
    if (n == -1 && PyErr_Occurred()) throw nb::python_error();
    return nb::cast(symbolic::power(a, n));
  }
  return python_operator<false>(power, "power")(a, exponent);
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

struct NamedUnary {
  const char* name;
  symbolic::UnaryOperation function;
  const char* doc;
};

Scalar sinh(const Scalar& x) {
  // Near zero the difference of exponentials cancels: sinh x = 2 t / (1 - t^2), t = tanh(x / 2).
  const Scalar t = symbolic::tanh(0.5 * x);
  const Scalar far = 0.5 * (symbolic::exp(x) - symbolic::exp(-x));
  return symbolic::select(symbolic::abs(x) < 1.0, 2.0 * t / (1.0 - t * t), far);
}
Scalar cosh(const Scalar& x) { return 0.5 * (symbolic::exp(x) + symbolic::exp(-x)); }

constexpr NamedUnary kUnary[] = {
    {"abs", symbolic::abs, "Absolute value; its derivative at 0 is 1."},
    {"sqrt", symbolic::sqrt, "Square root."},
    {"square", symbolic::square, "x x."},
    {"exp", symbolic::exp, "e to the power x."},
    {"log", symbolic::log, "Natural logarithm."},
    {"sin", symbolic::sin, "Sine of an angle [rad], |x| <= 1e9."},
    {"cos", symbolic::cos, "Cosine of an angle [rad], |x| <= 1e9."},
    {"tan", symbolic::tan, "Tangent of an angle [rad], |x| <= 1e9."},
    {"asin", symbolic::asin, "Inverse sine [rad]."},
    {"acos", symbolic::acos, "Inverse cosine [rad]."},
    {"atan", symbolic::atan, "Inverse tangent [rad]."},
    {"sinh", sinh, "Hyperbolic sine."},
    {"cosh", cosh, "Hyperbolic cosine."},
    {"tanh", symbolic::tanh, "Hyperbolic tangent."},
    {"held", symbolic::held, "The value of x, which derivatives take for a constant."},
};

TracedScalar where(nb::handle condition, nb::handle a, nb::handle b) {
  auto c = to_condition(condition);
  if (!c) c = require_traced(condition, "where: the condition");
  return symbolic::where(*c, require_traced(a, "where"), require_traced(b, "where"));
}

void bind_operators(nb::class_<TracedScalar>& c) {
  const nb::is_operator op;
  c.def("__add__", python_operator<false>(add, "+"), op);
  c.def("__radd__", python_operator<true>(add, "+"), op);
  c.def("__sub__", python_operator<false>(subtract, "-"), op);
  c.def("__rsub__", python_operator<true>(subtract, "-"), op);
  c.def("__mul__", python_operator<false>(multiply, "*"), op);
  c.def("__rmul__", python_operator<true>(multiply, "*"), op);
  c.def("__truediv__", python_operator<false>(divide, "/"), op);
  c.def("__rtruediv__", python_operator<true>(divide, "/"), op);
  c.def("__pow__", python_power, op);
  c.def("__rpow__", python_operator<true>(power, "power"), op);
  c.def("__lt__", python_operator<false>(less, "<"), op);
  c.def("__le__", python_operator<false>(less_equal, "<="), op);
  c.def("__gt__", python_operator<false>(greater, ">"), op);
  c.def("__ge__", python_operator<false>(greater_equal, ">="), op);
  c.def("__and__", python_operator<false, true>(both, "&"), op);
  c.def("__rand__", python_operator<true, true>(both, "&"), op);
  c.def("__or__", python_operator<false, true>(either, "|"), op);
  c.def("__ror__", python_operator<true, true>(either, "|"), op);
  c.def("__xor__", python_operator<false, true>(differ, "^"), op);
  c.def("__rxor__", python_operator<true, true>(differ, "^"), op);
  c.def("__invert__", [](const TracedScalar& a) {
    require_kind(a, true, "~");
    return TracedScalar{a.graph, !a.value};
  });
  c.def("__neg__", [](const TracedScalar& a) { return apply(negative, a, "-"); });
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
  for (const NamedUnary& f : kUnary)
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
