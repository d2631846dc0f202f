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
  BinaryOperation function;
  bool of_conditions = false;
};

inline constexpr BinaryOperator kAdd{"+", [](const Scalar& a, const Scalar& b) { return a + b; }};
inline constexpr BinaryOperator kSubtract{"-", [](const Scalar& a, const Scalar& b) { return a - b; }};
inline constexpr BinaryOperator kMultiply{"*", [](const Scalar& a, const Scalar& b) { return a * b; }};
inline constexpr BinaryOperator kDivide{"/", [](const Scalar& a, const Scalar& b) { return a / b; }};
/// Integral literal exponents are products, others real powers of a base >= 0.
inline constexpr BinaryOperator kPower{"power", [](const Scalar& a, const Scalar& b) { return pow(a, b); }};
inline constexpr BinaryOperator kLess{"<", [](const Scalar& a, const Scalar& b) { return a < b; }};
inline constexpr BinaryOperator kLessEqual{"<=", [](const Scalar& a, const Scalar& b) { return a <= b; }};
inline constexpr BinaryOperator kGreater{">", [](const Scalar& a, const Scalar& b) { return a > b; }};
inline constexpr BinaryOperator kGreaterEqual{">=", [](const Scalar& a, const Scalar& b) { return a >= b; }};
inline constexpr BinaryOperator kAnd{"&", [](const Scalar& a, const Scalar& b) { return a && b; }, true};
inline constexpr BinaryOperator kOr{"|", [](const Scalar& a, const Scalar& b) { return a || b; }, true};
inline constexpr BinaryOperator kXor{
    "^", [](const Scalar& a, const Scalar& b) { return (a && !b) || (!a && b); }, true};

}  // namespace stark::symbolic
