// Bindings of expression graphs: inputs, access to nodes, derivatives as expressions of the same graph.
#include <nanobind/stl/shared_ptr.h>
#include <nanobind/stl/string.h>
#include <nanobind/stl/vector.h>

#include <stark/base/error.h>
#include <stark/base/settings.h>

#include "symbolic.h"

namespace stark::bindings {

using namespace nb::literals;
using symbolic::Graph;
using symbolic::InputKind;

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
      .def_prop_ro(
          "stages", [](const Graph& g) { return std::vector<symbolic::NodeId>(g.stages()); },
          "Numbers of the nodes that were marked so.")
      .def("__len__", &Graph::size);
  m.def(
      "jacobian",
      [](nb::handle outputs, nb::handle wrt) {
        return symbolic::jacobian(require_traced_list(outputs, "jacobian: outputs"),
                                  require_traced_list(wrt, "jacobian: wrt"));
      },
      "outputs"_a, "wrt"_a, "Rows of derivatives of the outputs with respect to symbols.");
  m.def(
      "hessian",
      [](nb::handle output, nb::handle wrt) {
        return symbolic::hessian(require_traced(output, "hessian: the output"),
                                 require_traced_list(wrt, "hessian: wrt"));
      },
      "output"_a, "wrt"_a, "Rows of second derivatives of an output with respect to symbols.");
  m.def(
      "substitute",
      [](nb::handle outputs, nb::handle inputs, nb::handle values) {
        return symbolic::substitute(require_traced_list(outputs, "substitute: outputs"),
                                    require_traced_list(inputs, "substitute: inputs"),
                                    require_traced_list(values, "substitute: values"));
      },
      "outputs"_a, "inputs"_a, "values"_a,
      "Expressions of another graph, with these values in place of its inputs.");
}

void bind_nodes(nb::class_<TracedScalar>& c) {
  c.def_prop_ro(
       "graph", [](const TracedScalar& x) { return x.graph; }, "Graph, or None for a number.")
      .def_prop_ro(
          "id", [](const TracedScalar& x) { return x.value.id(); }, "Number of the node in its graph.")
      .def_prop_ro(
          "name", [](const TracedScalar& x) { return symbolic::name_of(x); }, "Name of an input, else ''.")
      .def_prop_ro("operation", symbolic::operation_of,
                   "'constant', 'input', or the operation: '+', 'sqrt', ...")
      .def_prop_ro("operands", symbolic::operands_of, "Scalars that the operation is applied to.")
      .def_prop_ro(
          "is_constant", [](const TracedScalar& x) { return x.value.is_constant(); }, "Known number?")
      .def_prop_ro(
          "is_condition", [](const TracedScalar& x) { return x.value.is_condition(); },
          "Made by a comparison?");
}

}  // namespace stark::bindings
