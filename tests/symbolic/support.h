// Shared by the tests of the symbolic engine: aligned arrays, a runner for kernels, second-order jets as an
// independent oracle of derivatives, random expressions.
#pragma once

#include <stark/symbolic/evaluate.h>
#include <stark/symbolic/kernel.h>
#include <stark/symbolic/tensor.h>

#include <bit>
#include <cmath>
#include <cstdint>
#include <random>
#include <string>
#include <vector>

namespace stark::symbolic::test {

using Random = std::mt19937_64;

inline double uniform(Random& r, double a, double b) {
  return std::uniform_real_distribution<double>(a, b)(r);
}

/// 64-byte aligned array.
class Lanes {
 public:
  explicit Lanes(size_t n) : memory_(n + 8, 0.0), size_(n) {
    offset_ = (64 - reinterpret_cast<uintptr_t>(memory_.data()) % 64) % 64 / sizeof(double);
  }
  double* data() { return memory_.data() + offset_; }
  const double* data() const { return memory_.data() + offset_; }
  double& operator[](size_t i) { return data()[i]; }
  double operator[](size_t i) const { return data()[i]; }
  size_t size() const { return size_; }

 private:
  std::vector<double> memory_;
  size_t offset_, size_;
};

/// Inputs of `blocks` blocks; value(kind, index, element) is stored as [block][index][lane].
inline Lanes pack(int count, const std::vector<std::vector<double>>& by_element) {
  const size_t blocks = (by_element.size() + kLanes - 1) / kLanes;
  Lanes result(blocks * static_cast<size_t>(count) * kLanes);
  for (size_t e = 0; e < blocks * kLanes; ++e) {
    const auto& values = by_element[e < by_element.size() ? e : by_element.size() - 1];
    for (size_t i = 0; i < static_cast<size_t>(count); ++i) {
      result[(e / kLanes * static_cast<size_t>(count) + i) * kLanes + e % kLanes] = values[i];
    }
  }
  return result;
}

struct Samples {
  std::vector<std::vector<double>> unknowns, elements;  // by element
  std::vector<double> uniforms;
};

/// Outputs by element.
inline std::vector<std::vector<double>> run(const Kernel& kernel, Order order, const Samples& samples) {
  const size_t count = samples.unknowns.size(), blocks = (count + kLanes - 1) / kLanes;
  const auto outputs = static_cast<size_t>(kernel.output_count(order));
  const Lanes u = pack(kernel.unknown_count(), samples.unknowns);
  std::vector<std::vector<double>> elements = samples.elements;
  elements.resize(count);
  const Lanes e = pack(kernel.element_count(), elements);
  Lanes out(blocks * outputs * kLanes);
  kernel.evaluate(order, u.data(), e.data(), samples.uniforms.data(), out.data(),
                  static_cast<int64_t>(blocks));
  std::vector<std::vector<double>> result(count, std::vector<double>(outputs));
  for (size_t k = 0; k < count; ++k) {
    for (size_t i = 0; i < outputs; ++i) result[k][i] = out[(k / kLanes * outputs + i) * kLanes + k % kLanes];
  }
  return result;
}

/// Equal bits, any NaN being equal to any other: the payload of a NaN depends on the order of operands.
inline bool same_bits(double a, double b) {
  return (std::isnan(a) && std::isnan(b)) || std::bit_cast<uint64_t>(a) == std::bit_cast<uint64_t>(b);
}

using Real = long double;

/// Value, gradient and Hessian carried forward in extended precision.
struct Jet {
  Real v = 0;
  std::vector<Real> g, h;  // h is n x n

  static Jet constant(Real value, size_t n) {
    return {value, std::vector<Real>(n, 0), std::vector<Real>(n * n, 0)};
  }
};

/// f(a) with f' and f'' given.
inline Jet chain(const Jet& a, Real f, Real d, Real dd) {
  const size_t n = a.g.size();
  Jet r = Jet::constant(f, n);
  for (size_t i = 0; i < n; ++i) {
    r.g[i] = d * a.g[i];
    for (size_t j = 0; j < n; ++j) r.h[i * n + j] = d * a.h[i * n + j] + dd * a.g[i] * a.g[j];
  }
  return r;
}
/// f(a, b) with its first and second partials given.
inline Jet chain(const Jet& a, const Jet& b, Real f, Real da, Real db, Real daa, Real dab, Real dbb) {
  const size_t n = a.g.size();
  Jet r = Jet::constant(f, n);
  for (size_t i = 0; i < n; ++i) {
    r.g[i] = da * a.g[i] + db * b.g[i];
    for (size_t j = 0; j < n; ++j) {
      r.h[i * n + j] = da * a.h[i * n + j] + db * b.h[i * n + j] + daa * a.g[i] * a.g[j] +
                       dbb * b.g[i] * b.g[j] + dab * (a.g[i] * b.g[j] + a.g[j] * b.g[i]);
    }
  }
  return r;
}

/// Jet of an expression with respect to all unknowns of its graph.
Jet evaluate_jet(const Scalar& expression, const InputValues& values);

/// Random smooth-almost-everywhere expression of `size` operations with choices in it; bounded for inputs in
/// [-1, 1].
Scalar random_expression(Graph& graph, Random& random, int unknowns, int elements, int uniforms, int size);

}  // namespace stark::symbolic::test
