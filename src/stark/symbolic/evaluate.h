// Plain evaluation and printing of expressions, for tests and messages; compiled functions without
// derivatives. Phase: model building and post-processing.
#pragma once

#include <stark/symbolic/expr.h>
#include <stark/symbolic/kernel.h>

#include <memory>
#include <span>
#include <string>
#include <vector>

namespace stark::symbolic {

/// Values of an expression's inputs; each span is indexed by the number of the input within its kind.
struct InputValues {
  std::span<const double> unknowns = {};
  std::span<const double> elements = {};
  std::span<const double> uniforms = {};
};

/// Value by the functions of the standard library (kernels use their own elementary functions, equal to about
/// 1 ulp).
double evaluate(const Scalar& expression, const InputValues& values);
/// Value of a condition.
bool evaluate_condition(const Scalar& condition, const InputValues& values);

/// Infix text with inputs by their names, or u0, e0, p0; shared sub-expressions are written out each time.
/// After `limit` characters the text stops with "...".
std::string to_string(const Scalar& expression, size_t limit = std::string::npos);
/// What an operation is called: "sqrt", "+", "neg", "select"; empty for leaves.
std::string name_of(Op op);

struct FunctionStatistics {
  int operations = 0;        // scalar operations of the expression graph
  int instructions = 0;      // after expansion of functions and fusion
  size_t code_bytes = 0;     // machine code only, with its constants
  double build_seconds = 0;  // lowering + code
};

struct FunctionState;

/// m outputs of the inputs of one graph, no derivatives, compiled as kernels are.
class Function {
 public:
  Function() = default;
  explicit operator bool() const { return state_ != nullptr; }
  int unknown_count() const;
  int element_count() const;
  int uniform_count() const;
  int output_count() const;
  Backend backend() const;
  const FunctionStatistics& statistics() const;
  /// Array layout as Kernel::evaluate, with output_count() outputs.
  void evaluate(const double* unknowns, const double* elements, const double* uniforms, double* out_values,
                int64_t block_count) const;

 private:
  friend Function compile_function(std::span<const std::vector<Scalar>>, Backend);
  std::shared_ptr<FunctionState> state_;
};

Function compile_function(std::span<const Scalar> outputs, Backend backend = Backend::Automatic);
/// Outputs of all groups, in order. Later groups do not change how earlier ones are rounded.
Function compile_function(std::span<const std::vector<Scalar>> groups, Backend backend = Backend::Automatic);

}  // namespace stark::symbolic
