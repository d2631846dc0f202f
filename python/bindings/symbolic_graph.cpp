// Bindings of expression graphs: inputs, access to nodes, derivatives as expressions of the same graph.
#include <nanobind/stl/shared_ptr.h>
#include <nanobind/stl/string.h>
#include <nanobind/stl/vector.h>

#include <stark/base/settings.h>
#include <stark/symbolic/evaluate.h>
#include <stark/symbolic/lower.h>
#include <stark/symbolic/partial_derivatives.h>

#include "symbolic.h"

namespace stark::bindings {

using namespace nb::literals;
using symbolic::Graph;
using symbolic::InputKind;
using symbolic::NodeId;
using symbolic::Op;
using symbolic::Scalar;

namespace {

InputKind input_kind(const std::string& kind) {
  if (kind == "unknown") return InputKind::Unknown;
  if (kind == "element") return InputKind::Element;
  if (kind == "uniform") return InputKind::Uniform;
  throw InvalidArgument("input kind '" + kind + "': need 'unknown', 'element' or 'uniform'" +
                        nearest_name_hint(kind, {"unknown", "element", "uniform"}));
}

TracedScalar new_input(const std::shared_ptr<Graph>& graph, const std::string& kind,
                       const std::string& name) {
  const TracedScalar input{graph, graph->input(input_kind(kind))};
  if (!name.empty()) graph->set_name(input.value, name);
  return input;
}

std::string operation_of(const TracedScalar& x) {
  if (!x.graph) return "constant";
  const Op op = x.graph->node(x.value.id()).op;
  if (op == Op::Constant) return "constant";
  return symbolic::operand_count(op) == 0 ? "input" : symbolic::name_of(op);
}

std::vector<TracedScalar> operands_of(const TracedScalar& x) {
  std::vector<TracedScalar> result;
  if (!x.graph) return result;
  const symbolic::Node& n = x.graph->node(x.value.id());
  for (int k = 0; k < symbolic::operand_count(n.op); ++k)
    result.push_back({x.graph, Scalar(x.graph.get(), n.operands[k])});
  return result;
}

std::string name_of(const TracedScalar& x) { return x.graph ? x.graph->name(x.value.id()) : ""; }

std::vector<NodeId> nodes_of(const std::vector<TracedScalar>& values, const TracedScalar& anchor,
                             const std::string& name) {
  std::vector<NodeId> ids;
  for (const TracedScalar& value : values) {
    common_graph(anchor, value, name);
    require_kind(value, false, name);
    // Simplification may dissolve intermediate values, as in (2 x) (2 x) = 4 (x x); symbols stay.
    if (value.value.is_constant() || !operands_of(value).empty())
      throw TraceError(name + ": cannot differentiate with respect to " + short_text(value) +
                       ", only with respect to symbols; make the formula a function of that value with "
                       "@stark.symbolic.function and call its gradient, jacobian or hessian");
    ids.push_back(value.value.id());
  }
  return ids;
}

std::vector<TracedScalar> traced(const std::shared_ptr<Graph>& graph, const std::vector<NodeId>& ids) {
  std::vector<TracedScalar> result;
  for (const NodeId id : ids) result.push_back({graph, Scalar(graph.get(), id)});
  return result;
}

/// Rows of d outputs / d targets.
std::vector<std::vector<TracedScalar>> jacobian(nb::handle outputs, nb::handle targets) {
  const auto wrt = require_traced_list(targets, "jacobian: wrt");
  std::vector<std::vector<TracedScalar>> rows;
  for (const TracedScalar& y : require_traced_list(outputs, "jacobian: outputs")) {
    require_kind(y, false, "jacobian");
    if (!y.graph) {
      rows.emplace_back(wrt.size(), TracedScalar{nullptr, Scalar(0.0)});
      continue;
    }
    const auto ids = nodes_of(wrt, y, "jacobian");
    rows.push_back(traced(y.graph, symbolic::partial_derivatives(*y.graph, y.value.id(), ids)));
  }
  return rows;
}

/// Full rows of the second derivatives of y.
std::vector<std::vector<TracedScalar>> hessian(nb::handle output, nb::handle targets) {
  const TracedScalar y = require_traced(output, "hessian: the output");
  require_kind(y, false, "hessian");
  const auto wrt = require_traced_list(targets, "hessian: wrt");
  const size_t n = wrt.size();
  std::vector<std::vector<TracedScalar>> rows(n, std::vector<TracedScalar>(n, {nullptr, Scalar(0.0)}));
  if (!y.graph) return rows;
  const auto entries =
      symbolic::second_partial_derivatives(*y.graph, y.value.id(), nodes_of(wrt, y, "hessian"));
  for (size_t i = 0, k = 0; i < n; ++i)
    for (size_t j = i; j < n; ++j, ++k)
      rows[i][j] = rows[j][i] = {y.graph, Scalar(y.graph.get(), entries[k])};
  return rows;
}

/// Expressions of one graph, with values of another in place of its inputs.
std::vector<TracedScalar> substitute(nb::handle outputs, nb::handle inputs, nb::handle values) {
  const auto expressions = require_traced_list(outputs, "substitute: outputs");
  const auto leaves = require_traced_list(inputs, "substitute: inputs");
  const auto given = require_traced_list(values, "substitute: values");
  STARK_CHECK(leaves.size() == given.size());
  TracedScalar source, target;
  for (const TracedScalar& y : expressions) source.graph = common_graph(source, y, "substitute");
  if (!source.graph) return expressions;
  for (const TracedScalar& value : given) {
    require_kind(value, false, "argument");
    target.graph = common_graph(target, value, "arguments");
  }
  if (!target.graph) target.graph = std::make_shared<Graph>();
  STARK_CHECK(source.graph != target.graph);
  std::vector<NodeId> image(source.graph->size(), -1), roots;
  for (size_t k = 0; k < leaves.size(); ++k) {
    const Scalar& value = given[k].value;
    image[leaves[k].value.id()] = value.is_literal() ? target.graph->constant(value.value()) : value.id();
  }
  for (const TracedScalar& y : expressions)
    roots.push_back(y.graph ? y.value.id() : source.graph->constant(y.value.value()));
  image.resize(source.graph->size(), -1);
  return traced(target.graph, import_expressions(*source.graph, roots, *target.graph, std::move(image)));
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
      .def("__len__", &Graph::size);
  m.def("jacobian", jacobian, "outputs"_a, "wrt"_a,
        "Rows of derivatives of the outputs with respect to symbols.");
  m.def("hessian", hessian, "output"_a, "wrt"_a,
        "Rows of second derivatives of an output with respect to symbols.");
  m.def("substitute", substitute, "outputs"_a, "inputs"_a, "values"_a,
        "Expressions of another graph, with these values in place of its inputs.");
}

void bind_nodes(nb::class_<TracedScalar>& c) {
  c.def_prop_ro(
       "graph", [](const TracedScalar& x) { return x.graph; }, "Graph, or None for a number.")
      .def_prop_ro(
          "id", [](const TracedScalar& x) { return x.value.id(); }, "Number of the node in its graph.")
      .def_prop_ro("name", name_of, "Name of an input, else ''.")
      .def_prop_ro("operation", operation_of, "'constant', 'input', or the operation: '+', 'sqrt', ...")
      .def_prop_ro("operands", operands_of, "Scalars that the operation is applied to.")
      .def_prop_ro(
          "is_constant", [](const TracedScalar& x) { return x.value.is_constant(); }, "Known number?")
      .def_prop_ro(
          "is_condition", [](const TracedScalar& x) { return x.value.is_condition(); },
          "Made by a comparison?");
}

}  // namespace stark::bindings
