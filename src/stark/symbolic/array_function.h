// Functions of arrays: values and derivatives of an expression over batches of any strides, for formulas that
// are used on their own. Potentials of simulations use Kernel directly. Phase: post-processing, no time step.
#pragma once

#include <stark/symbolic/evaluate.h>
#include <stark/symbolic/expr.h>
#include <stark/symbolic/kernel.h>

#include <cstdint>
#include <memory>
#include <span>
#include <string>
#include <vector>

namespace stark::symbolic {

/// One argument: its scalars, which are inputs of the graph, and whether derivatives are wanted.
struct ArrayArgument {
  std::string name;
  std::vector<Scalar> inputs;
  bool differentiated = false;
};

/// Values of one argument over a batch: scalar k of element (i, j, ...) is data[i s_i + j s_j + ... +
/// offsets[k]].
struct StridedArray {
  const double* data = nullptr;
  std::vector<int64_t> strides;  // [number], by dimension of the batch; 0 where all elements share the value
  std::vector<int64_t> offsets;  // [number], by scalar of the argument
};

/// View of an array of this shape and these strides [number] whose last dimensions are those of an argument,
/// `own` many, and whose leading ones broadcast to a batch of so many dimensions.
StridedArray broadcast(const double* data, std::span<const int64_t> shape, std::span<const int64_t> strides,
                       size_t own, size_t batch);

/// Row-major results, any of them null: values (count, m), first derivatives (count, m, n), second
/// derivatives (count, n, n) for n scalars of differentiated arguments, in order.
struct ArrayResults {
  double* values = nullptr;
  double* first = nullptr;
  double* second = nullptr;
};

struct ArrayFunctionStatistics {
  int operations = 0, instructions = 0;
  size_t code_bytes = 0;     // machine code only
  double build_seconds = 0;  // differentiation, lowering, code
  std::string algorithm;     // how second derivatives are formed; empty for lower orders
};

struct ArrayFunctionState;

/// Immutable, cheap to copy, safe to call from several threads. The code of an order is built at its first
/// use. Values have the same bits in every order.
class ArrayFunction {
 public:
  /// m outputs of one graph. Throws TraceError if an output is a condition or uses an input that is in no
  /// argument.
  ArrayFunction(std::span<const Scalar> outputs, std::span<const ArrayArgument> arguments,
                Backend backend = Backend::Automatic);

  int output_count() const;
  /// Number n of scalars of differentiated arguments.
  int variable_count() const;
  /// Whether the outputs depend on any scalar of an argument.
  bool uses(int argument) const;
  Backend backend() const;

  /// Evaluates up to `order` for every element of a batch of this shape. Second derivatives need m = 1; they
  /// throw InvalidArgument otherwise.
  void evaluate(Order order, std::span<const StridedArray> arguments, std::span<const int64_t> shape,
                const ArrayResults& out_results) const;

  /// Builds the code of an order if needed.
  ArrayFunctionStatistics statistics(Order order) const;

 private:
  std::shared_ptr<ArrayFunctionState> state_;
};

}  // namespace stark::symbolic

template <>
struct stark::Readings<stark::symbolic::ArrayFunctionStatistics> {
  using S = symbolic::ArrayFunctionStatistics;
  static constexpr std::tuple kAll{
      reading<&S::operations>("operations"), reading<&S::instructions>("instructions"),
      reading<&S::code_bytes>("code_bytes"), reading<&S::build_seconds>("build_seconds"),
      reading<&S::algorithm>("algorithm")};
};
