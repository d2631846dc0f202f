// Traced scalars at the border: a value of an expression graph together with a share in the graph, so that a
// formula lives as long as any part of it that Python holds.
#pragma once

#include <nanobind/nanobind.h>

#include <memory>
#include <optional>
#include <string>
#include <vector>

#include <stark/base/error.h>
#include <stark/symbolic/expr.h>

namespace stark::bindings {

namespace nb = nanobind;

/// A node of a graph, or a number (no graph). A number may stand for a condition, as `1.0 < 2.0` does.
struct TracedScalar {
  std::shared_ptr<symbolic::Graph> graph;
  symbolic::Scalar value;
};

/// The one graph of two operands, null if both are numbers. Throws TraceError if they have different graphs.
inline std::shared_ptr<symbolic::Graph> common_graph(const TracedScalar& a, const TracedScalar& b,
                                                     const std::string& operation) {
  if (a.graph && b.graph && a.graph != b.graph)
    throw TraceError(
        operation +
        ": the operands come from two different formulas; every value of a formula has to be made "
        "from its own arguments. Do not keep traced values for later.");
  return a.graph ? a.graph : b.graph;
}

/// A traced scalar, or a number of Python or NumPy (also an array without dimensions); nothing for other
/// types.
std::optional<TracedScalar> to_traced(nb::handle object);
/// The same; throws TraceError that says what `name` got instead.
TracedScalar require_traced(nb::handle object, const std::string& name);
/// The items of a sequence; throws TraceError naming the place of one that is not a scalar.
std::vector<TracedScalar> require_traced_list(nb::handle sequence, const std::string& name);

/// Formula of a scalar for messages, cut where it is long.
std::string short_text(const TracedScalar& x);
/// Throws TraceError unless the scalar is a condition, or a number, as asked.
void require_kind(const TracedScalar& x, bool condition, const std::string& operation);

/// Graphs and derivatives, and what a scalar says about its node (symbolic_graph.cpp).
void bind_graph(nb::module_& m);
void bind_nodes(nb::class_<TracedScalar>& c);
/// Compiled functions of arrays (symbolic_functions.cpp).
void bind_array_functions(nb::module_& m);

}  // namespace stark::bindings
