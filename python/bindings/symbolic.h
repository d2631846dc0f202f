// Traced scalars at the border: from what Python has to those of symbolic/traced_scalar.
#pragma once

#include <nanobind/nanobind.h>

#include <optional>
#include <string>
#include <vector>

#include <stark/symbolic/traced_scalar.h>

namespace stark::bindings {

namespace nb = nanobind;

using symbolic::TracedScalar;

/// A traced scalar, or a number of Python or NumPy (also an array without dimensions); nothing for other
/// types.
std::optional<TracedScalar> to_traced(nb::handle object);
/// The same; throws TraceError that says what `name` got instead.
TracedScalar require_traced(nb::handle object, const std::string& name);
/// The items of a sequence; throws TraceError naming the place of one that is not a scalar.
std::vector<TracedScalar> require_traced_list(nb::handle sequence, const std::string& name);

/// Graphs and derivatives, and what a scalar says about its node (symbolic_graph.cpp).
void bind_graph(nb::module_& m);
void bind_nodes(nb::class_<TracedScalar>& c);
/// Compiled functions of arrays (symbolic_functions.cpp).
void bind_array_functions(nb::module_& m);

}  // namespace stark::bindings
