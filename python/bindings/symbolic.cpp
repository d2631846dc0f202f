// Bindings of expression graphs: inputs, nodes, derivatives, traced scalars with the operators and functions
// of Python. Formulas are built by running Python code on traced scalars, so whatever would need their values
// raises TraceError.
#include "symbolic.h"

#include <cmath>

#include <stark/symbolic/array_function.h>
#include <stark/symbolic/named_functions.h>

#include "without_gil.h"

namespace stark::bindings {

using symbolic::ArrayFunction;
using symbolic::BinaryOperator;
using symbolic::Graph;
using symbolic::Order;
using symbolic::Scalar;

namespace {

/// Python refuses to write integers of thousands of digits, so the message has their number of digits.
[[noreturn]] void refuse_too_large(nb::handle integer) {
  const auto digits =
      std::lround(nb::cast<double>(nb::float_(integer.attr("bit_length")())) * std::log10(2.0));
  throw TraceError("an integer of about " + std::to_string(digits) +
                   " digits: numbers of a formula must be below 1.8e308 in size; choose units in which they "
                   "are smaller, or calculate with logarithms");
}

}  // namespace

std::optional<TracedScalar> to_traced(nb::handle object) {
  TracedScalar* traced = nullptr;
  if (nb::try_cast(object, traced, false) && traced != nullptr) return *traced;
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
  if (value == -1.0 && PyErr_Occurred()) {
    if (!PyErr_ExceptionMatches(PyExc_OverflowError)) throw nb::python_error();
    PyErr_Clear();
    refuse_too_large(object);
  }
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

/// bool becomes a condition where one is meant.
std::optional<TracedScalar> to_condition(nb::handle object) {
  if (PyBool_Check(object.ptr()) || (nb::hasattr(object, "dtype") && text(object.attr("dtype")) == "bool"))
    return TracedScalar{nullptr, Scalar::literal_condition(nb::cast<bool>(nb::bool_(object)))};
  return to_traced(object);
}

/// The operator of Python, with the scalar on the left or on the right; other types get their turn by
/// NotImplemented.
nb::object operate(const BinaryOperator& op, const TracedScalar& self, nb::handle other,
                   bool on_the_right = false) {
  const auto operand = op.of_conditions ? to_condition(other) : to_traced(other);
  if (!operand) return nb::borrow(Py_NotImplemented);
  return nb::cast(apply(op.function, on_the_right ? *operand : self, on_the_right ? self : *operand,
                        op.of_conditions, op.symbol));
}

/// Products for integer exponents, else the real power of a base >= 0.
nb::object pow(nb::handle base, nb::handle exponent) {
  const TracedScalar a = require_traced(base, "pow");
  if (!PyLong_Check(exponent.ptr())) return operate(symbolic::kPower, a, exponent);
  int overflow = 0;
  const long long n = PyLong_AsLongLongAndOverflow(exponent.ptr(), &overflow);
  if (n == -1 && PyErr_Occurred()) throw nb::python_error();
  if (overflow != 0) {
    require_traced(exponent, "power");  // refuses what no float holds
    throw TraceError("power: the exponent " + text(exponent) + " is too large; write it as a float");
  }
  return nb::cast(symbolic::power(a, n));
}

/// An operator that formulas do not have.
template <auto refuse>
void refused(const TracedScalar& x, nb::handle) {
  refuse(x);
}

/// a where the condition holds, else b. The other branch never contributes, not even as NaN.
TracedScalar where(nb::handle condition, nb::handle a, nb::handle b) {
  auto c = to_condition(condition);
  if (!c) c = require_traced(condition, "where: the condition");
  return symbolic::where(*c, require_traced(a, "where"), require_traced(b, "where"));
}

bool is_same(const TracedScalar& a, const TracedScalar& b) { return symbolic::is_same(a.value, b.value); }

/// The scalar that stands for a number; scalars are returned as they are.
TracedScalar constant(nb::handle x) { return require_traced(x, "constant"); }

TracedScalar new_input(const std::shared_ptr<Graph>& graph, symbolic::InputKind kind,
                       const std::string& name) {
  const TracedScalar input{graph, graph->input(kind)};
  if (!name.empty()) graph->set_name(input.value, name);
  return input;
}

void mark_stage(Graph& graph, const TracedScalar& value) { graph.mark_stage(value.value); }

void set_name(Graph& graph, const TracedScalar& value, const std::string& name) {
  graph.set_name(value.value, name);
}

void bind_graph(nb::module_& m) {
  nb::class_<Graph> c(m, "Graph", "Expression graph: equal expressions are one node. Not for two threads.");
  c.def(nb::init<>());
  def(c, "input", new_input, {{"kind", "unknown"}, {"name", ""}},
      "New input. kind: 'unknown' (differentiated), 'element' (one value per element) or 'uniform'.");
  c.def("mark_stage", mark_stage, "value"_a,
        "Hint for differentiation: derivatives may go through this value. Never changes results.");
  c.def("set_name", set_name, "value"_a, "name"_a, "Names a value for printing.");
  c.def_prop_ro("stages", [](const Graph& g) { return std::vector<symbolic::NodeId>(g.stages()); });
  def(c, "__len__", &Graph::size);
  m.def("jacobian", bound<2>(symbolic::jacobian, {"jacobian: outputs", "jacobian: wrt"}), "outputs"_a,
        "wrt"_a);
  m.def("hessian", bound<2>(symbolic::hessian, {"hessian: the output", "hessian: wrt"}), "output"_a, "wrt"_a);
  m.def("substitute",
        bound<3>(symbolic::substitute, {"substitute: outputs", "substitute: inputs", "substitute: values"}),
        "outputs"_a, "inputs"_a, "values"_a);
}

void bind_nodes(nb::class_<TracedScalar>& c) {
  property(c, "graph", &TracedScalar::graph, "Graph, or None for a number.");
  property(c, "id", path<&TracedScalar::value, &Scalar::id>, "Number of the node in its graph.");
  property(c, "name", nb::overload_cast<const TracedScalar&>(&symbolic::name_of), "Of an input, else ''.");
  property(c, "operation", symbolic::operation_of, "'constant', 'input', or the operation: '+', 'sqrt', ...");
  property(c, "operands", symbolic::operands_of, "Scalars that the operation is applied to.");
  property(c, "is_constant", path<&TracedScalar::value, &Scalar::is_constant>, "Known number?");
  property(c, "is_condition", path<&TracedScalar::value, &Scalar::is_condition>, "Made by a comparison?");
}

void bind_operators(nb::class_<TracedScalar>& c) {
  const auto on = [&c](const std::string& name, const BinaryOperator& op, bool on_the_right) {
    const auto call = [&op, on_the_right](const TracedScalar& self, nb::handle other) {
      return operate(op, self, other, on_the_right);
    };
    c.def(("__" + name + "__").c_str(), call, nb::is_operator());
  };
  for (const BinaryOperator& op : symbolic::kBinaryOperators) {
    on(op.name, op, false);
    if (!op.is_comparison) on(std::string("r") + op.name, op, true);
  }
  c.def("__pow__", pow, nb::is_operator());
  on("rpow", symbolic::kPower, true);
  c.def("__invert__", symbolic::inverted);
  c.def("__neg__", symbolic::negative);
  c.def("__pos__", [](const TracedScalar& a) { return a; });
  c.def("__abs__", [](const TracedScalar& a) { return apply(symbolic::abs, a, "abs"); });
  for (const char* name : {"__eq__", "__ne__"})
    c.def(name, refused<symbolic::refuse_equality>, "other"_a.none());
  for (const char* name : {"__mod__", "__rmod__", "__floordiv__", "__rfloordiv__"})
    c.def(name, refused<symbolic::refuse_rounding>);
  c.def("__hash__", [](nb::handle self) { return reinterpret_cast<Py_ssize_t>(self.ptr()) >> 4; });
  c.def("__bool__", symbolic::constant_truth);
  c.def("__float__", [](const TracedScalar& x) { return constant_value(x, "float()"); });
  c.def("__int__", [](const TracedScalar& x) { return nb::int_(nb::float_(constant_value(x, "int()"))); });
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
  def<pow>(m, {"base", "exponent"});
  def<where>(m, {"condition", "a", "b"});
  m.def("fma", bound<3>(symbolic::fused_multiply_add, {"fma", "fma", "fma"}), "a"_a, "b"_a, "c"_a);
  m.def("is_same", is_same, "a"_a, "b"_a, "Whether two scalars are the same expression.");
  def<constant>(m, {"x"});
  const auto is_scalar_like = [](nb::handle x) { return to_traced(x).has_value(); };
  m.def("is_scalar_like", is_scalar_like, "x"_a.none(), "Whether the value is a scalar or a number.");
}

// Compiled functions of arrays: NumPy arrays of any strides in, new arrays out, without the lock of the
// interpreter while code is built for an order or runs.

using AnyArray = nb::ndarray<const double, nb::device::cpu>;
using Shape = std::vector<int64_t>;
/// Name, scalars, whether it is differentiated.
using Input = std::tuple<std::string, nb::object, bool>;

ArrayFunction compile_arrays(nb::handle outputs, const std::vector<Input>& arguments,
                             symbolic::Backend backend) {
  std::vector<Scalar> values;
  for (const TracedScalar& y : require_traced_list(outputs, "outputs")) values.push_back(y.value);
  std::vector<symbolic::ArrayArgument> inputs;
  for (const auto& [name, scalars, differentiated] : arguments) {
    symbolic::ArrayArgument& argument = inputs.emplace_back();
    argument.name = name;
    argument.differentiated = differentiated;
    for (const TracedScalar& x : require_traced_list(scalars, name)) argument.inputs.push_back(x.value);
  }
  return ArrayFunction(values, inputs, backend);
}

/// New array of zeros of the given shape, and where its numbers are. NumPy gets the memory from the system
/// already cleared, and in large pages.
std::pair<nb::object, double*> zeros(const Shape& batch, const Shape& own) {
  nb::list shape;
  for (const int64_t d : batch) shape.append(d);
  for (const int64_t d : own) shape.append(d);
  nb::object array = nb::module_::import_("numpy").attr("zeros")(shape);
  return {array, nb::cast<nb::ndarray<double, nb::c_contig, nb::device::cpu>>(array).data()};
}

/// Arrays of values, first and second derivatives, None where not asked for. Every array is float64 with its
/// own shape last; `own_shapes` and `batch` are what the caller has checked them against.
nb::tuple evaluate(const ArrayFunction& f, Order order, bool with_values, bool with_first,
                   const std::vector<AnyArray>& arrays, const std::vector<Shape>& own_shapes,
                   const Shape& batch) {
  std::vector<symbolic::StridedArray> arguments;
  for (size_t a = 0; a < arrays.size(); ++a) {
    const AnyArray& array = arrays[a];
    const std::span shape(array.shape_ptr(), array.ndim()), strides(array.stride_ptr(), array.ndim());
    arguments.push_back(
        symbolic::broadcast(array.data(), shape, strides, own_shapes[a].size(), batch.size()));
  }
  const int64_t m = f.output_count(), n = f.variable_count();
  nb::object values = nb::none(), first = nb::none(), second = nb::none();
  symbolic::ArrayResults results;
  if (with_values) std::tie(values, results.values) = zeros(batch, {m});
  if (with_first) std::tie(first, results.first) = zeros(batch, {m, n});
  if (order == Order::Hessian) std::tie(second, results.second) = zeros(batch, {n, n});
  without_gil([&] { f.evaluate(order, arguments, batch, results); });
  return nb::make_tuple(values, first, second);
}

void bind_array_functions(nb::module_& m) {
  using F = ArrayFunction;
  nb::class_<F> c(m, "ArrayFunction", "Compiled values and derivatives of expressions over batches.");
  property<&F::backend>(c);
  def(c, "uses", &F::uses, {"argument"}, "Whether the outputs depend on an argument.");
  c.def("evaluate", evaluate, "order"_a, "with_values"_a, "with_first"_a, "arrays"_a, "own_shapes"_a,
        "batch"_a, "(values, first derivatives, second derivatives), None where not asked for.");
  def(c, "statistics", &F::statistics, {"order"}, "Counts of one order; builds its code if needed.");
  m.def("compile_arrays", compile_arrays, "outputs"_a, "arguments"_a, "backend"_a = "automatic",
        "Compiles outputs as a function of arguments, which are (name, scalars, differentiated).");
  def(m, "best_backend", symbolic::best_backend,
      "Name of the back end that 'automatic' stands for on this machine.");
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
