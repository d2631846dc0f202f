// Lane-batched LDL^T test and Jacobi projection. Matrices are handled four at a time, one per lane of a 256-bit
// vector; sizes are compile-time constants so that the sweeps unroll.
#include <stark/base/psd.h>

#include <cmath>
#include <cstring>
#include <limits>

#include <stark/base/error.h>
#include <stark/base/simd.h>

namespace stark {

namespace {

using simd::absolute, simd::fma, simd::load, simd::select, simd::splat, simd::store;
using V = simd::VDouble;
using Mask = simd::MaskDouble;
constexpr int kWidth = simd::kWidth<double>;  // matrices handled at once

constexpr double kTestTolerance = 1e-12;  // of the absolute diagonal sum
constexpr int kMaxSweeps = 12;            // cyclic Jacobi needs 5 to 7 at these sizes
// A lane stops when its off-diagonal norm is below this multiple of its Frobenius norm: the error of an eigenvalue is
// then of the order of its square over the gap, or of the multiple itself for a cluster.
constexpr double kOffTolerance = 1e-15;

uint32_t lane_bits(Mask mask) {
  uint32_t bits = 0;
  for (int l = 0; l < kWidth; ++l) bits |= mask[l] != 0 ? 1u << l : 0u;
  return bits;
}
Mask lane_mask(uint32_t bits) {
  Mask mask;
  for (int l = 0; l < kWidth; ++l) mask[l] = (bits >> l & 1u) != 0 ? -1 : 0;
  return mask;
}

constexpr int upper_index(int n, int i, int j) { return i * n - i * (i - 1) / 2 + (j - i); }

// Sizes: N > 0 is a compile-time n, N = 0 takes n at run time.
template <int N>
struct Size {
  int runtime;
  constexpr int value() const { return N > 0 ? N : runtime; }
};
constexpr int capacity(int n) { return n > 0 ? n : kPsdMaxSize; }

// Bits of the four lanes at `upper` that are not positive semidefinite.
template <int N>
uint32_t test_lanes(const double* upper, Size<N> size) {
  const int n = size.value();
  constexpr int kMax = capacity(N);
  V a[kMax * (kMax + 1) / 2];
  V scale = splat(0.0);
  for (int k = 0; k < n * (n + 1) / 2; ++k) a[k] = load(upper + kPsdLanes * k);
  for (int i = 0; i < n; ++i) scale += absolute(a[upper_index(n, i, i)]);
  // The shift lets singular matrices pass in spite of round-off; its smallest value keeps zero matrices from 0 / 0.
  const V shift = scale * kTestTolerance + std::numeric_limits<double>::min();
  Mask good = lane_mask(0xf);
  for (int i = 0; i < n; ++i) {
    const V* row = a + upper_index(n, i, i);
    const V pivot = row[0] + shift;
    good &= pivot > 0.0;
    const V inverse = splat(1.0) / pivot;
    for (int j = i + 1; j < n; ++j) {
      const V factor = -row[j - i] * inverse;
      V* target = a + upper_index(n, j, j);
      for (int k = j; k < n; ++k) target[k - j] = fma(factor, row[k - i], target[k - j]);
    }
  }
  return ~lane_bits(good) & 0xfu;
}

// Projects the four lanes of the full matrix a[n][n] (upper triangle used) selected by `bits`.
template <int N>
void project_lanes(V* a, Size<N> size, uint32_t bits) {
  const int n = size.value();
  constexpr int kMax = capacity(N);
  V v[kMax * kMax];  // row k: eigenvector k
  for (int i = 0; i < n; ++i)
    for (int j = 0; j < n; ++j) v[i * n + j] = splat(i == j ? 1.0 : 0.0);
  V frobenius = splat(0.0);
  for (int i = 0; i < n; ++i)
    for (int j = i; j < n; ++j) frobenius = fma(a[i * n + j], a[i * n + j] * (i == j ? 1.0 : 2.0), frobenius);
  const V stop = frobenius * (kOffTolerance * kOffTolerance);
  // Lanes that are done, or were never asked for, get identity rotations: their bits do not depend on the others.
  Mask active = lane_mask(bits) & (frobenius < std::numeric_limits<double>::infinity());
  for (int sweep = 0; sweep < kMaxSweeps; ++sweep) {
    V off = splat(0.0);
    for (int i = 0; i < n; ++i)
      for (int j = i + 1; j < n; ++j) off = fma(a[i * n + j], a[i * n + j], off);
    active &= off + off > stop;
    if (lane_bits(active) == 0) break;
    for (int p = 0; p < n - 1; ++p) {
      for (int q = p + 1; q < n; ++q) {
        const V apq = a[p * n + q], app = a[p * n + p], aqq = a[q * n + q];
        // t = tan of the rotation angle, the smaller root of t^2 + 2 theta t - 1 = 0, written without division by apq.
        const V half = (aqq - app) * 0.5;
        const V root = simd::sqrt(fma(half, half, apq * apq));
        const V denominator = absolute(half) + root;
        const Mask rotate = active & (denominator > 0.0);
        const V signed_apq = half < 0.0 ? -apq : apq;
        const V t = select(rotate, signed_apq / select(rotate, denominator, splat(1.0)), splat(0.0));
        const V c = splat(1.0) / simd::sqrt(fma(t, t, splat(1.0)));
        const V s = t * c;
        a[p * n + p] = fma(-t, apq, app);
        a[q * n + q] = fma(t, apq, aqq);
        a[p * n + q] = select(rotate, splat(0.0), apq);
        const auto turn = [&](V& x, V& y) {
          const V old_x = x, old_y = y;
          x = fma(c, old_x, -(s * old_y));
          y = fma(s, old_x, c * old_y);
        };
        for (int k = 0; k < p; ++k) turn(a[k * n + p], a[k * n + q]);
        for (int k = p + 1; k < q; ++k) turn(a[p * n + k], a[k * n + q]);
        for (int k = q + 1; k < n; ++k) turn(a[p * n + k], a[q * n + k]);
        for (int k = 0; k < n; ++k) turn(v[p * n + k], v[q * n + k]);
      }
    }
  }
  V lambda[kMax];
  for (int k = 0; k < n; ++k) lambda[k] = a[k * n + k] > 0.0 ? a[k * n + k] : splat(0.0);
  for (int i = 0; i < n; ++i)
    for (int j = i; j < n; ++j) a[i * n + j] = splat(0.0);
  for (int k = 0; k < n; ++k)
    for (int i = 0; i < n; ++i) {
      const V scaled = lambda[k] * v[k * n + i];
      for (int j = i; j < n; ++j) a[i * n + j] = fma(scaled, v[k * n + j], a[i * n + j]);
    }
}

// Orthonormal basis of the vectors on `points` points that sum to zero (Helmert): row k is (1, .., 1, -k, 0, ..) over
// sqrt(k (k + 1)), with k ones.
double helmert(int k, int point) {
  const double scale = 1.0 / std::sqrt(static_cast<double>(k) * (k + 1));
  return point < k ? scale : point == k ? -k * scale : 0.0;
}

template <int N>
void load_full(const double* upper, int n, V* a) {
  int k = 0;
  for (int i = 0; i < n; ++i)
    for (int j = i; j < n; ++j) a[i * n + j] = a[j * n + i] = load(upper + kPsdLanes * k++);
}

template <int N>
void store_selected(double* upper, int n, const V* a, uint32_t bits) {
  V frobenius = splat(0.0);
  int k = 0;
  for (int i = 0; i < n; ++i)
    for (int j = i; j < n; ++j) frobenius += load(upper + kPsdLanes * k) * 0.0, ++k;
  const Mask write = lane_mask(bits) & (frobenius == 0.0);  // not a NaN or infinity
  k = 0;
  for (int i = 0; i < n; ++i)
    for (int j = i; j < n; ++j, ++k) {
      double* target = upper + kPsdLanes * k;
      store(target, select(write, a[i * n + j], load(target)));
    }
}

template <int N>
void project_half(double* upper, Size<N> size, uint32_t bits) {
  const int n = size.value();
  constexpr int kMax = capacity(N);
  V a[kMax * kMax];
  load_full<N>(upper, n, a);
  project_lanes<N>(a, size, bits);
  store_selected<N>(upper, n, a, bits);
}

// The same on the n - 3 dimensions orthogonal to the translations.
template <int N>
void project_half_invariant(double* upper, uint32_t bits) {
  constexpr int kPoints = N / 3, kReduced = N - 3;
  V a[N * N], half[kReduced * N], b[kReduced * kReduced];
  load_full<N>(upper, N, a);
  for (int k = 1; k < kPoints; ++k)
    for (int c = 0; c < 3; ++c)
      for (int j = 0; j < N; ++j) {
        V sum = splat(0.0);
        for (int i = 0; i <= k; ++i) sum = fma(splat(helmert(k, i)), a[(3 * i + c) * N + j], sum);
        half[(3 * (k - 1) + c) * N + j] = sum;
      }
  for (int r = 0; r < kReduced; ++r)
    for (int k = 1; k < kPoints; ++k)
      for (int c = 0; c < 3; ++c) {
        V sum = splat(0.0);
        for (int i = 0; i <= k; ++i) sum = fma(splat(helmert(k, i)), half[r * N + 3 * i + c], sum);
        b[r * kReduced + 3 * (k - 1) + c] = sum;
      }
  project_lanes<kReduced>(b, Size<kReduced>{kReduced}, bits);
  for (int r = 0; r < kReduced; ++r)
    for (int s = 0; s < r; ++s) b[r * kReduced + s] = b[s * kReduced + r];
  for (int r = 0; r < kReduced; ++r)
    for (int i = 0; i < kPoints; ++i)
      for (int c = 0; c < 3; ++c) {
        V sum = splat(0.0);
        for (int k = i > 0 ? i : 1; k < kPoints; ++k)
          sum = fma(splat(helmert(k, i)), b[r * kReduced + 3 * (k - 1) + c], sum);
        half[r * N + 3 * i + c] = sum;
      }
  for (int i = 0; i < kPoints; ++i)
    for (int c = 0; c < 3; ++c)
      for (int j = 3 * i + c; j < N; ++j) {
        V sum = splat(0.0);
        for (int k = i > 0 ? i : 1; k < kPoints; ++k)
          sum = fma(splat(helmert(k, i)), half[(3 * (k - 1) + c) * N + j], sum);
        a[(3 * i + c) * N + j] = sum;
      }
  store_selected<N>(upper, N, a, bits);
}

template <typename Function>
void for_each_half(uint32_t mask, Function&& function) {
  for (int half = 0; half < kPsdLanes / kWidth; ++half) {
    const uint32_t bits = mask >> (kWidth * half) & 0xfu;
    if (bits != 0) function(half, bits);
  }
}

}  // namespace

uint32_t psd_test(const double* upper, int n) {
  STARK_CHECK(n >= 1 && n <= kPsdMaxSize);
  uint32_t result = 0;
  for_each_half(0xffu, [&](int half, uint32_t) {
    const double* lanes = upper + kWidth * half;
    uint32_t bits = 0;
    switch (n) {
      case 3: bits = test_lanes<3>(lanes, {n}); break;
      case 6: bits = test_lanes<6>(lanes, {n}); break;
      case 9: bits = test_lanes<9>(lanes, {n}); break;
      case 12: bits = test_lanes<12>(lanes, {n}); break;
      default: bits = test_lanes<0>(lanes, {n});
    }
    result |= bits << (kWidth * half);
  });
  return result;
}

void psd_project(double* upper, int n, uint32_t mask, bool translation_invariant) {
  STARK_CHECK(n >= 1 && n <= kPsdMaxSize);
  STARK_CHECK(!translation_invariant || n == 6 || n == 9 || n == 12);
  for_each_half(mask, [&](int half, uint32_t bits) {
    double* lanes = upper + kWidth * half;
    if (translation_invariant) {
      switch (n) {
        case 6: project_half_invariant<6>(lanes, bits); break;
        case 9: project_half_invariant<9>(lanes, bits); break;
        default: project_half_invariant<12>(lanes, bits);
      }
      return;
    }
    switch (n) {
      case 3: project_half<3>(lanes, {n}, bits); break;
      case 6: project_half<6>(lanes, {n}, bits); break;
      case 9: project_half<9>(lanes, {n}, bits); break;
      case 12: project_half<12>(lanes, {n}, bits); break;
      default: project_half<0>(lanes, {n}, bits);
    }
  });
}

Mat3 psd_project(const Mat3& a) {
  double upper[6 * kPsdLanes] = {};
  int k = 0;
  for (int i = 0; i < 3; ++i)
    for (int j = i; j < 3; ++j) upper[kPsdLanes * k++] = 0.5 * (a(i, j) + a(j, i));
  psd_project(upper, 3, 1u);
  Mat3 result;
  k = 0;
  for (int i = 0; i < 3; ++i)
    for (int j = i; j < 3; ++j) result(i, j) = result(j, i) = upper[kPsdLanes * k++];
  return result;
}

}  // namespace stark
