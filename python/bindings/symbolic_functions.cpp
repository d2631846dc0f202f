// Bindings of compiled functions of arrays: NumPy arrays of any strides in, new arrays out, without the lock
// of the interpreter while code is built for an order or runs.
#include <tuple>
#include <utility>

#include <stark/symbolic/array_function.h>

#include "symbolic.h"
#include "without_gil.h"

namespace stark::bindings {

using symbolic::ArrayFunction;
using symbolic::Order;
using symbolic::Scalar;
using symbolic::StridedArray;

namespace {

using AnyArray = nb::ndarray<const double, nb::device::cpu>;
using Shape = std::vector<int64_t>;
/// Name, scalars, whether it is differentiated.
using Argument = std::tuple<std::string, nb::object, bool>;

ArrayFunction compile_arrays(nb::handle outputs, const std::vector<Argument>& arguments,
                             const std::string& backend) {
  std::vector<Scalar> values;
  for (const TracedScalar& y : require_traced_list(outputs, "outputs")) values.push_back(y.value);
  std::vector<symbolic::ArrayArgument> inputs;
  for (const auto& [name, scalars, differentiated] : arguments) {
    symbolic::ArrayArgument& argument = inputs.emplace_back();
    argument.name = name;
    argument.differentiated = differentiated;
    for (const TracedScalar& x : require_traced_list(scalars, name)) argument.inputs.push_back(x.value);
  }
  return ArrayFunction(values, inputs, backend_of(backend));
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
  std::vector<StridedArray> arguments;
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

nb::dict statistics(const ArrayFunction& f, Order order) {
  const symbolic::ArrayFunctionStatistics s = f.statistics(order);
  return dict_of("operations", s.operations, "instructions", s.instructions, "code_bytes", s.code_bytes,
                 "build_seconds", s.build_seconds, "algorithm", s.algorithm);
}

}  // namespace

void bind_array_functions(nb::module_& m) {
  nb::class_<ArrayFunction>(m, "ArrayFunction",
                            "Compiled values and derivatives of expressions over batches.")
      .def_prop_ro("backend", &ArrayFunction::backend)
      .def("uses", &ArrayFunction::uses, "argument"_a, "Whether the outputs depend on an argument.")
      .def("evaluate", evaluate, "order"_a, "with_values"_a, "with_first"_a, "arrays"_a, "own_shapes"_a,
           "batch"_a, "(values, first derivatives, second derivatives), None where not asked for.")
      .def("statistics", statistics, "order"_a, "Counts of one order; builds its code if needed.");
  m.def("compile_arrays", compile_arrays, "outputs"_a, "arguments"_a, "backend"_a = "automatic",
        "Compiles outputs as a function of arguments, which are (name, scalars, differentiated).");
  m.def("best_backend", &symbolic::best_backend,
        "Name of the back end that 'automatic' stands for on this machine.");
}

}  // namespace stark::bindings
