// Seeded random points for tests, generic and degenerate.
#pragma once

#include <random>

#include <stark/base/math.h>

namespace stark::test {

class RandomPoints {
 public:
  explicit RandomPoints(unsigned seed) : random_(seed) {}

  double uniform(double low = -1.0, double high = 1.0) {
    return std::uniform_real_distribution<double>(low, high)(random_);
  }
  int integer(int low, int high) { return std::uniform_int_distribution<int>(low, high)(random_); }
  Vec3 point() { return {uniform(), uniform(), uniform()}; }
  /// Small integer coordinates: many coincident, collinear, coplanar and parallel configurations.
  Vec3 lattice(int extent = 2) {
    return {double(integer(-extent, extent)), double(integer(-extent, extent)),
            double(integer(-extent, extent))};
  }

 private:
  std::mt19937 random_;
};

}  // namespace stark::test
