// Scalars that are recorded while a formula runs, each with a share in its graph, so that a formula lives as
// long as any part of it that is held. Whoever records is told what cannot be: TraceError says why and what
// to write instead. The front end is Python's (python/bindings/symbolic.cpp).
#pragma once

#include <memory>
#include <string>
#include <vector>

#include <stark/symbolic/expr.h>

namespace stark::symbolic {

/// A node of a graph, or a number (no graph). A number may stand for a condition, as `1.0 < 2.0` does.
struct TracedScalar {
  std::shared_ptr<Graph> graph;
  Scalar value;
};

/// The one graph of two operands, null if both are numbers. Throws TraceError if they have different graphs.
std::shared_ptr<Graph> common_graph(const TracedScalar& a, const TracedScalar& b,
                                    const std::string& operation);
/// Formula of a scalar for messages, cut where it is long.
std::string short_text(const TracedScalar& x);
/// Throws TraceError unless the scalar is a condition, or a number, as asked.
void require_kind(const TracedScalar& x, bool condition, const std::string& operation);

/// The number that a constant is, converted as by "float()". What is not one throws TraceError: values are
/// not known while a formula is recorded.
double constant_value(const TracedScalar& x, const std::string& conversion);
/// Whether a constant, or a condition between constants, is true; throws TraceError for others.
bool constant_truth(const TracedScalar& x);
/// What formulas never have: equality of computed numbers, rounding, values as indices. Throw TraceError.
[[noreturn]] void refuse_equality(const TracedScalar& x);
[[noreturn]] void refuse_rounding(const TracedScalar& x);
[[noreturn]] void refuse_index(const TracedScalar& x);

using UnaryOperation = Scalar (*)(const Scalar&);
using BinaryOperation = Scalar (*)(const Scalar&, const Scalar&);
/// Of numbers, or of `conditions`; `operation` is for messages. Throws TraceError.
TracedScalar apply(UnaryOperation function, const TracedScalar& a, const char* operation);
TracedScalar apply(BinaryOperation function, const TracedScalar& a, const TracedScalar& b, bool conditions,
                   const char* operation);
/// -a; of a condition, that it does not hold. Throw TraceError for the other kind.
TracedScalar negative(const TracedScalar& a);
TracedScalar inverted(const TracedScalar& a);
/// A product of as many factors; throws TraceError for exponents that are no int.
TracedScalar power(const TracedScalar& a, long long exponent);
/// a where the condition holds, else b.
TracedScalar where(const TracedScalar& condition, const TracedScalar& a, const TracedScalar& b);
/// a b + c with one rounding.
TracedScalar fused_multiply_add(const TracedScalar& a, const TracedScalar& b, const TracedScalar& c);

/// "constant", "input", or the operation: "+", "sqrt", ...
std::string operation_of(const TracedScalar& x);
std::vector<TracedScalar> operands_of(const TracedScalar& x);
/// Of an input, else "".
std::string name_of(const TracedScalar& x);

/// Rows of derivatives of the outputs with respect to symbols. Throws TraceError for values that are none.
std::vector<std::vector<TracedScalar>> jacobian(const std::vector<TracedScalar>& outputs,
                                                const std::vector<TracedScalar>& wrt);
/// Full rows of the second derivatives of y.
std::vector<std::vector<TracedScalar>> hessian(const TracedScalar& y, const std::vector<TracedScalar>& wrt);
/// Expressions of one graph with values of another one, as many, in place of inputs.
std::vector<TracedScalar> substitute(const std::vector<TracedScalar>& expressions,
                                     const std::vector<TracedScalar>& inputs,
                                     const std::vector<TracedScalar>& values);

}  // namespace stark::symbolic
