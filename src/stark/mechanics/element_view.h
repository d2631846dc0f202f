// Access to one element (lane) of a kernel's lane-major output: energy, gradient, upper triangle of the
// Hessian.
#pragma once

#include <stark/base/math.h>
#include <stark/symbolic/kernel.h>

namespace stark {

class ElementView {
 public:
  /// out: outputs of one block of lanes for Order::Hessian with n unknowns.
  ElementView(const double* out, int n, int lane) : out_(out + lane), n_(n) {}

  double energy() const { return out_[0]; }
  double gradient(int i) const { return out_[(1 + i) * symbolic::kLanes]; }
  Vec3 point_gradient(int p) const { return {gradient(3 * p), gradient(3 * p + 1), gradient(3 * p + 2)}; }
  double hessian(int i, int j) const {
    if (i > j) std::swap(i, j);
    return out_[(1 + n_ + i * n_ - i * (i - 1) / 2 + (j - i)) * symbolic::kLanes];
  }
  /// Block (p, q) of the Hessian.
  Mat3 point_hessian(int p, int q) const {
    Mat3 block;
    if (p < q) {  // rows of the upper triangle are contiguous
      for (int a = 0; a < 3; ++a) {
        const int i = 3 * p + a;
        const double* row = out_ + (1 + n_ + i * n_ - i * (i - 1) / 2 - i + 3 * q) * symbolic::kLanes;
        for (int b = 0; b < 3; ++b) block(a, b) = row[b * symbolic::kLanes];
      }
    } else {
      for (int a = 0; a < 3; ++a)
        for (int b = 0; b < 3; ++b) block(a, b) = hessian(3 * p + a, 3 * q + b);
    }
    return block;
  }

 private:
  const double* out_;
  int n_;
};

}  // namespace stark
