// Bindings of expression graphs: inputs, access to nodes, derivatives as expressions of the same graph.
#include <stark/base/error.h>
#include <stark/base/settings.h>

#include "symbolic.h"

namespace stark::bindings {

using symbolic::Graph;
using symbolic::InputKind;
using symbolic::Scalar;

namespace {

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

}  // namespace

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

}  // namespace stark::bindings
