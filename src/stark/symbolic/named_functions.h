// The functions and operators of formulas by name, for front ends that are not C++.
#pragma once

#include <stark/symbolic/traced_scalar.h>

namespace stark::symbolic {

struct NamedUnary {
  const char* name;
  UnaryOperation function;
  const char* doc;
};

inline constexpr NamedUnary kUnaryFunctions[] = {
    {"abs", abs, "Absolute value; its derivative at 0 is 1."},
    {"sqrt", sqrt, "Square root."},
    {"square", square, "x x."},
    {"exp", exp, "e to the power x."},
    {"log", log, "Natural logarithm."},
    {"sin", sin, "Sine of an angle [rad], |x| <= 1e9."},
    {"cos", cos, "Cosine of an angle [rad], |x| <= 1e9."},
    {"tan", tan, "Tangent of an angle [rad], |x| <= 1e9."},
    {"asin", asin, "Inverse sine [rad]."},
    {"acos", acos, "Inverse cosine [rad]."},
    {"atan", atan, "Inverse tangent [rad]."},
    {"sinh", sinh, "Hyperbolic sine."},
    {"cosh", cosh, "Hyperbolic cosine."},
    {"tanh", tanh, "Hyperbolic tangent."},
    {"held", held, "The value of x, which derivatives take for a constant."},
    {"total", total, "The sum of x over all elements of an energy."},
};

struct NamedBinary {
  const char* name;
  BinaryOperation function;
  const char *first, *second;  ///< arguments
  const char* doc;
};

inline constexpr NamedBinary kBinaryFunctions[] = {
    {"minimum", min, "a", "b", "a < b ? a : b."},
    {"maximum", max, "a", "b", "a > b ? a : b."},
    {"atan2", atan2, "y", "x", "Angle [rad] of the direction (x, y)."},
};

struct BinaryOperator {
  const char* symbol;
  const char* name;  ///< of the method of Python: __add__, and __radd__ with the operands the other way round
  BinaryOperation function;
  bool is_comparison = false;  ///< has no method for operands the other way round
  bool of_conditions = false;
};

inline constexpr BinaryOperator kBinaryOperators[] = {
    {"+", "add", [](const Scalar& a, const Scalar& b) { return a + b; }},
    {"-", "sub", [](const Scalar& a, const Scalar& b) { return a - b; }},
    {"*", "mul", [](const Scalar& a, const Scalar& b) { return a * b; }},
    {"/", "truediv", [](const Scalar& a, const Scalar& b) { return a / b; }},
    {"<", "lt", [](const Scalar& a, const Scalar& b) { return a < b; }, true},
    {"<=", "le", [](const Scalar& a, const Scalar& b) { return a <= b; }, true},
    {">", "gt", [](const Scalar& a, const Scalar& b) { return a > b; }, true},
    {">=", "ge", [](const Scalar& a, const Scalar& b) { return a >= b; }, true},
    {"&", "and", [](const Scalar& a, const Scalar& b) { return a && b; }, false, true},
    {"|", "or", [](const Scalar& a, const Scalar& b) { return a || b; }, false, true},
    {"^", "xor", [](const Scalar& a, const Scalar& b) { return (a && !b) || (!a && b); }, false, true},
};
/// Integral literal exponents are products, others real powers of a base >= 0.
inline constexpr BinaryOperator kPower{"power", "pow",
                                       [](const Scalar& a, const Scalar& b) { return pow(a, b); }};

}  // namespace stark::symbolic
