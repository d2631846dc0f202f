// A kernel evaluates an energy, its gradient and its Hessian for many elements at once. It is compiled in
// process from an expression: differentiation, lowering to straight-line code, machine code (or the
// interpreter, same bits). Phase: built when a model is built; evaluated in every assembly.
#pragma once

#include <stark/base/reading.h>
#include <stark/base/settings.h>
#include <stark/symbolic/expr.h>

#include <array>
#include <cstddef>
#include <cstdint>
#include <memory>
#include <string>

namespace stark::symbolic {

/// Elements per block, on every back end.
inline constexpr int kLanes = 8;

enum class Order : uint8_t { Energy = 0, Gradient = 1, Hessian = 2 };

/// Automatic: machine code for the best instruction set of this processor, or the interpreter where
/// executable memory is refused. All back ends give the same bits.
enum class Backend : uint8_t { Automatic, Interpreter, Avx2, Avx512, Neon };

}  // namespace stark::symbolic

template <>
struct stark::EnumNames<stark::symbolic::InputKind> {
  static constexpr const char* kNoun = "input kind";
  static constexpr std::array<std::string_view, 3> kNames{"unknown", "element", "uniform"};
};
template <>
struct stark::EnumNames<stark::symbolic::Backend> {
  static constexpr const char* kNoun = "backend";
  static constexpr std::array<std::string_view, 5> kNames{"automatic", "interpreter", "avx2", "avx512",
                                                          "neon"};
};

namespace stark::symbolic {

struct KernelStatistics {
  std::array<int, 3> operations{};        // scalar operations of the expression graph, by order
  std::array<int, 3> instructions{};      // after expansion of functions and fusion, by order
  std::array<int, 3> spill_slots{};       // machine code only
  std::array<size_t, 3> code_bytes{};     // machine code only, with its constants
  std::array<double, 3> build_seconds{};  // differentiation + lowering + code, by order
  std::string algorithm;                  // how the Hessian was formed
  Backend backend = Backend::Interpreter;
};

struct KernelState;

/// Immutable, cheap to copy, safe to call from several threads. The code of an order is built at its first
/// use.
class Kernel {
 public:
  Kernel() = default;
  explicit operator bool() const { return state_ != nullptr; }

  int unknown_count() const;
  int element_count() const;
  int uniform_count() const;
  /// 1; 1 + n; 1 + n + n (n + 1) / 2 for n unknowns.
  int output_count(Order order) const;

  /// Lane-major arrays, 64-byte aligned: unknowns [block][unknown_count][kLanes], elements
  /// [block][element_count][kLanes], uniforms [uniform_count] (any alignment), out_values
  /// [block][output_count(order)][kLanes]: energy, gradient, upper triangle of the Hessian row by row (i <=
  /// j). Lanes are independent of each other. The energy has the same bits in every order.
  void evaluate(Order order, const double* unknowns, const double* elements, const double* uniforms,
                double* out_values, int64_t block_count) const;

  /// Builds the code of an order now instead of at its first use.
  void prepare(Order order) const;
  Backend backend() const;
  /// Hash of the formula: equal for equal formulas, on every back end and in every process.
  uint64_t fingerprint() const;
  /// Builds all three orders if needed.
  const KernelStatistics& statistics() const;

 private:
  friend Kernel compile(const Scalar&, Backend);
  std::shared_ptr<KernelState> state_;
};

/// Throws InvalidArgument if the expression is a condition or the back end does not exist on this machine.
/// Kernels of equal expressions are shared while one of them is alive.
Kernel compile(const Scalar& energy, Backend backend = Backend::Automatic);

/// Machine code for the best instruction set of this processor, or Interpreter if there is none.
Backend best_backend();
std::string to_string(Backend backend);

}  // namespace stark::symbolic

template <>
struct stark::Readings<stark::symbolic::KernelStatistics> {
  using S = symbolic::KernelStatistics;
  static constexpr std::tuple kAll{
      reading<&S::operations>("operations"), reading<&S::instructions>("instructions"),
      reading<&S::code_bytes>("code_bytes"), reading<&S::build_seconds>("build_seconds"),
      reading<&S::algorithm>("algorithm"),   reading<&S::backend>("backend")};
};
