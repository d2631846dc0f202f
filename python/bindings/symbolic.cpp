// Bindings of expression graphs: inputs, nodes, derivatives, traced scalars with the operators and functions
// of Python. Formulas are built by running Python code on traced scalars, so whatever would need their values
// raises TraceError.
#include "symbolic.h"

#include <stark/base/error.h>
#include <stark/symbolic/evaluate.h>
#include <stark/symbolic/named_functions.h>

#include "arrays.h"

namespace stark::bindings {

using symbolic::BinaryOperator;
using symbolic::Graph;
using symbolic::InputKind;
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

/// An operator that formulas do not have.
template <auto refuse>
void refused(const TracedScalar& x, nb::handle) {
  refuse(x);
}

// Functions.

TracedScalar where(nb::handle condition, nb::handle a, nb::handle b) {
  auto c = to_condition(condition);
  if (!c) c = require_traced(condition, "where: the condition");
  return symbolic::where(*c, require_traced(a, "where"), require_traced(b, "where"));
}

// Graphs.

InputKind input_kind(const std::string& kind) {
  if (kind == "unknown") return InputKind::Unknown;
  if (kind == "element") return InputKind::Element;
  if (kind == "uniform") return InputKind::Uniform;
  throw InvalidArgument("input kind '" + kind + "': must be 'unknown', 'element' or 'uniform'" +
                        nearest_name_hint(kind, {"unknown", "element", "uniform"}));
}

TracedScalar new_input(const std::shared_ptr<Graph>& graph, const std::string& kind,
                       const std::string& name) {
  const TracedScalar input{graph, graph->input(input_kind(kind))};
  if (!name.empty()) graph->set_name(input.value, name);
  return input;
}

void bind_graph(nb::module_& m) {
  nb::class_<Graph>(m, "Graph", "Expression graph: equal expressions are one node. Not for two threads.")
      .def(nb::init<>())
      .def("input", new_input, "kind"_a = "unknown", "name"_a = "",
           "New input. kind: 'unknown' (differentiated), 'element' (one value per element) or 'uniform'.")
      .def(
          "input_count",
          [](const Graph& g, const std::string& kind) { return g.input_count(input_kind(kind)); }, "kind"_a,
          "Number of inputs of a kind.")
      .def(
          "mark_stage", [](Graph& g, const TracedScalar& value) { g.mark_stage(value.value); }, "value"_a,
          "Hint for differentiation: derivatives may go through this value. Never changes results.")
      .def(
          "set_name",
          [](Graph& g, const TracedScalar& value, const std::string& name) { g.set_name(value.value, name); },
          "value"_a, "name"_a, "Names a value for printing.")
      .def_prop_ro(
          "stages", [](const Graph& g) { return std::vector<symbolic::NodeId>(g.stages()); },
          "Numbers of the nodes that were marked so.")
      .def("__len__", &Graph::size);
  m.def("jacobian", with_arrays<symbolic::jacobian, "jacobian: outputs", "jacobian: wrt">, "outputs"_a,
        "wrt"_a, "Rows of derivatives of the outputs with respect to symbols.");
  m.def("hessian", with_arrays<symbolic::hessian, "hessian: the output", "hessian: wrt">, "output"_a, "wrt"_a,
        "Rows of second derivatives of an output with respect to symbols.");
  m.def("substitute",
        with_arrays<symbolic::substitute, "substitute: outputs", "substitute: inputs", "substitute: values">,
        "outputs"_a, "inputs"_a, "values"_a,
        "Expressions of another graph, with these values in place of its inputs.");
}

void bind_nodes(nb::class_<TracedScalar>& c) {
  c.def_prop_ro("graph", path<&TracedScalar::graph>, "Graph, or None for a number.")
      .def_prop_ro("id", path<&TracedScalar::value, &Scalar::id>, "Number of the node in its graph.")
      .def_prop_ro("name", nb::overload_cast<const TracedScalar&>(&symbolic::name_of),
                   "Name of an input, else ''.")
      .def_prop_ro("operation", symbolic::operation_of,
                   "'constant', 'input', or the operation: '+', 'sqrt', ...")
      .def_prop_ro("operands", symbolic::operands_of, "Scalars that the operation is applied to.")
      .def_prop_ro("is_constant", path<&TracedScalar::value, &Scalar::is_constant>, "Known number?")
      .def_prop_ro("is_condition", path<&TracedScalar::value, &Scalar::is_condition>,
                   "Made by a comparison?");
}

void bind_operators(nb::class_<TracedScalar>& c) {
  const auto on = [&c](const char* name, const BinaryOperator& op, bool on_the_right = false) {
    const auto call = [&op, on_the_right](const TracedScalar& self, nb::handle other) {
      return operate(op, self, other, on_the_right);
    };
    c.def(name, call, nb::is_operator());
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
  c.def("__eq__", refused<symbolic::refuse_equality>, "other"_a.none());
  c.def("__ne__", refused<symbolic::refuse_equality>, "other"_a.none());
  c.def("__hash__", [](nb::handle self) { return reinterpret_cast<Py_ssize_t>(self.ptr()) >> 4; });
  for (const char* name : {"__mod__", "__rmod__", "__floordiv__", "__rfloordiv__"})
    c.def(name, refused<symbolic::refuse_rounding>);
  c.def("__bool__", symbolic::constant_truth);
  c.def("__float__", [](const TracedScalar& x) { return constant_value(x, "float()"); });
  c.def("__int__", [](const TracedScalar& x) { return static_cast<long long>(constant_value(x, "int()")); });
  c.def("__index__", symbolic::refuse_index, nb::sig("def __index__(self) -> int"));
  c.def("__repr__", [](const TracedScalar& x) { return "Scalar(" + to_string(x.value, 200) + ")"; });
}

void bind_functions(nb::module_& m) {
  for (const symbolic::NamedUnary& f : symbolic::kUnaryFunctions) {
    const auto call = [f](nb::handle x) { return apply(f.function, require_traced(x, f.name), f.name); };
    m.def(f.name, call, "x"_a, f.doc);
  }
  for (const symbolic::NamedBinary& f : symbolic::kBinaryFunctions) {
    const auto call = [f](nb::handle a, nb::handle b) {
      return apply(f.function, require_traced(a, f.name), require_traced(b, f.name), false, f.name);
    };
    m.def(f.name, call, nb::arg(f.first), nb::arg(f.second), f.doc);
  }
  m.def(
      "pow", [](nb::handle a, nb::handle b) { return python_power(require_traced(a, "pow"), b); }, "base"_a,
      "exponent"_a, "Power: products for integer exponents, else the real power of a base >= 0.");
  m.def("where", where, "condition"_a, "a"_a, "b"_a,
        "a where the condition holds, else b. The other branch never contributes, not even as NaN.");
  m.def("fma", with_arrays<symbolic::fused_multiply_add, "fma", "fma", "fma">, "a"_a, "b"_a, "c"_a,
        "a b + c with one rounding.");
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

void bind_symbolic(nb::module_& parent) {
  nb::module_ m = parent.def_submodule("symbolic", "Expression graphs, derivatives, machine code.");
  bind_graph(m);
  nb::class_<TracedScalar> scalar(m, "Scalar", "A number of a formula: recorded, not computed.");
  bind_operators(scalar);
  bind_nodes(scalar);
  bind_functions(m);
  bind_array_functions(m);
}

}  // namespace stark::bindings
