// Lane-batched LDL^T test and eigenvalue projection. Matrices are handled eight at a time, one per lane of
// two 256-bit vectors; the usual sizes are compile-time constants, so that the inner loops unroll.
#include <stark/base/psd.h>

#include <cmath>
#include <cstring>
#include <limits>

#include <stark/base/error.h>
#include <stark/base/simd.h>

namespace stark {

namespace {

// Eight lanes as two vectors: chains of square roots and divisions of one hide behind those of the other.
struct V {
  simd::VDouble low, high;
  V& operator+=(const V& b) { return low += b.low, high += b.high, *this; }
  V& operator-=(const V& b) { return low -= b.low, high -= b.high, *this; }
  V& operator*=(const V& b) { return low *= b.low, high *= b.high, *this; }
};
struct Mask {
  simd::MaskDouble low, high;
  Mask& operator&=(const Mask& b) { return low &= b.low, high &= b.high, *this; }
};
constexpr int kWidth = simd::kWidth<double>;

V splat(double a) { return {simd::splat(a), simd::splat(a)}; }
V load(const double* p) { return {simd::load(p), simd::load(p + kWidth)}; }
void store(double* p, const V& a) { simd::store(p, a.low), simd::store(p + kWidth, a.high); }
V operator-(const V& a) { return {-a.low, -a.high}; }
V operator+(const V& a, const V& b) { return {a.low + b.low, a.high + b.high}; }
V operator-(const V& a, const V& b) { return {a.low - b.low, a.high - b.high}; }
V operator*(const V& a, const V& b) { return {a.low * b.low, a.high * b.high}; }
V operator/(const V& a, const V& b) { return {a.low / b.low, a.high / b.high}; }
V operator+(const V& a, double b) { return a + splat(b); }
V operator*(const V& a, double b) { return a * splat(b); }
Mask operator>(const V& a, const V& b) { return {a.low > b.low, a.high > b.high}; }
Mask operator>(const V& a, double b) { return a > splat(b); }
Mask operator<(const V& a, double b) { return splat(b) > a; }
Mask operator==(const V& a, double b) { return {a.low == simd::splat(b), a.high == simd::splat(b)}; }
Mask operator&(Mask a, const Mask& b) { return a &= b; }
Mask operator|(const Mask& a, const Mask& b) { return {a.low | b.low, a.high | b.high}; }
V select(const Mask& mask, const V& a, const V& b) {
  return {simd::select(mask.low, a.low, b.low), simd::select(mask.high, a.high, b.high)};
}
V fma(const V& a, const V& b, const V& c) {
  return {simd::fma(a.low, b.low, c.low), simd::fma(a.high, b.high, c.high)};
}
V sqrt(const V& a) { return {simd::sqrt(a.low), simd::sqrt(a.high)}; }
V absolute(const V& a) { return {simd::absolute(a.low), simd::absolute(a.high)}; }

constexpr double kTestTolerance = 1e-12;  // of the absolute diagonal sum
constexpr int kMaxSteps = 40;             // QR steps per eigenvalue; two or three are usual
constexpr double kNegligible = 1e-16;     // off-diagonal entry taken as zero, the matrix being scaled to one

uint32_t lane_bits(const Mask& mask) {
  uint32_t bits = 0;
  for (int l = 0; l < kWidth; ++l) {
    bits |= mask.low[l] != 0 ? 1u << l : 0u;
    bits |= mask.high[l] != 0 ? 1u << (kWidth + l) : 0u;
  }
  return bits;
}
Mask lane_mask(uint32_t bits) {
  Mask mask;
  for (int l = 0; l < kWidth; ++l) {
    mask.low[l] = (bits >> l & 1u) != 0 ? -1 : 0;
    mask.high[l] = (bits >> (kWidth + l) & 1u) != 0 ? -1 : 0;
  }
  return mask;
}
/// The power of two below a positive number.
V power_of_two_below(const V& a) {
  constexpr int64_t kExponent = 0x7ff0000000000000;
  return {(simd::VDouble)((simd::MaskDouble)a.low & kExponent),
          (simd::VDouble)((simd::MaskDouble)a.high & kExponent)};
}

constexpr int upper_index(int n, int i, int j) { return i * n - i * (i - 1) / 2 + (j - i); }

// Sizes: N > 0 is a compile-time n; N = 0 takes n at run time, up to that of eight points, as energies and
// joints have them, and N = -1 any n. What is on the stack is as large as the largest of them.
constexpr int kCommonSize = 24;
template <int N>
struct Size {
  int runtime;
  constexpr int value() const { return N > 0 ? N : runtime; }
};
constexpr int capacity(int n) { return n > 0 ? n : n == 0 ? kCommonSize : kPsdMaxSize; }

// Bits of the lanes at `upper` that are not positive semidefinite.
template <int N>
uint32_t test_lanes(const double* upper, Size<N> size) {
  const int n = size.value();
  constexpr int kMax = capacity(N);
  V a[kMax * (kMax + 1) / 2];
  V scale = splat(0.0);
  for (int k = 0; k < n * (n + 1) / 2; ++k) a[k] = load(upper + kPsdLanes * k);
  for (int i = 0; i < n; ++i) scale += absolute(a[upper_index(n, i, i)]);
  // The shift lets singular matrices pass in spite of round-off; its smallest value keeps zero matrices from
  // 0 / 0.
  const V shift = scale * kTestTolerance + std::numeric_limits<double>::min();
  Mask good = lane_mask(0xff);
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
  return ~lane_bits(good) & 0xffu;
}

// Brings the full matrices a[n][n] to tridiagonal form d, e by Householder reflections, collected in the rows
// of v[n][n]: a = v^T T v.
template <int N>
void tridiagonalize(V* a, Size<N> size, V* d, V* e, V* v) {
  const int n = size.value();
  constexpr int kMax = capacity(N);
  V beta[kMax], w[kMax];
  for (int k = 0; k + 2 < n; ++k) {
    // The reflection of row k beyond the diagonal onto its first entry; its vector overwrites the row.
    V* const x = a + k * n;
    V tail = x[k + 2] * x[k + 2];
    for (int i = k + 3; i < n; ++i) tail = fma(x[i], x[i], tail);
    const V norm = sqrt(fma(x[k + 1], x[k + 1], tail));
    const Mask reflect = tail > 0.0;
    const V first = x[k + 1];
    e[k] = select(reflect, select(first > 0.0, -norm, norm), first);
    x[k + 1] = first - e[k];
    beta[k] =
        select(reflect, splat(1.0) / select(reflect, fma(norm, absolute(first), norm * norm), splat(1.0)),
               splat(0.0));
    V product = splat(0.0);
    for (int i = k + 1; i < n; ++i) {
      V sum = splat(0.0);
      for (int j = k + 1; j < n; ++j) sum = fma(a[i * n + j], x[j], sum);
      w[i] = sum * beta[k];
      product = fma(w[i], x[i], product);
    }
    const V half = product * beta[k] * 0.5;
    for (int i = k + 1; i < n; ++i) w[i] = fma(-half, x[i], w[i]);
    for (int i = k + 1; i < n; ++i) {
      const V xi = -x[i], wi = -w[i];
      for (int j = k + 1; j < n; ++j) a[i * n + j] = fma(xi, w[j], fma(wi, x[j], a[i * n + j]));
    }
  }
  for (int i = 0; i < n; ++i) d[i] = a[i * n + i];
  if (n > 1) e[n - 2] = a[(n - 2) * n + n - 1];
  for (int i = 0; i < n; ++i)
    for (int j = 0; j < n; ++j) v[i * n + j] = splat(i == j ? 1.0 : 0.0);
  for (int k = n - 3; k >= 0; --k) {
    const V* const x = a + k * n;
    for (int i = k + 1; i < n; ++i) {
      V* const row = v + i * n;
      V sum = splat(0.0);
      for (int j = k + 1; j < n; ++j) sum = fma(row[j], x[j], sum);
      sum = -sum * beta[k];
      for (int j = k + 1; j < n; ++j) row[j] = fma(sum, x[j], row[j]);
    }
  }
}

// Diagonalises d, e by implicit QR steps with Wilkinson's shift, turning the rows of v[n][n]. Lanes that are
// done, or not `wanted`, get identity rotations, which keep their bits.
template <int N>
void diagonalize(V* d, V* e, V* v, Size<N> size, Mask wanted) {
  const int n = size.value();
  for (int last = n - 1; last > 0; --last) {
    for (int step = 0; step < kMaxSteps; ++step) {
      const Mask active = wanted & (absolute(e[last - 1]) > kNegligible);
      if (lane_bits(active) == 0) break;
      // The bottom block of each lane that is not yet split starts at `start`.
      V start = splat(0.0);
      for (int k = 1; k < last; ++k)
        start = select(absolute(e[k - 1]) > kNegligible, start, splat(static_cast<double>(k)));
      const V half = (d[last - 1] - d[last]) * 0.5, corner = e[last - 1];
      const V root = sqrt(fma(half, half, corner * corner));
      const V denominator = select(half < 0.0, half - root, half + root);
      const V shift =
          d[last] - select(active, corner * corner / select(active, denominator, splat(1.0)), splat(0.0));
      V x = splat(0.0), z = splat(0.0);
      for (int k = 0; k < last; ++k) {
        const Mask here = active & (start == static_cast<double>(k));
        const Mask inside = active & (start < static_cast<double>(k));
        x = select(here, d[k] - shift, x);
        z = select(here, e[k], z);
        const V r = sqrt(fma(x, x, z * z));
        const Mask turn = r > 0.0;
        const V inverse = splat(1.0) / select(turn, r, splat(1.0));
        const V c = select(turn, x * inverse, splat(1.0)), s = z * inverse;
        if (k > 0) e[k - 1] = select(inside, r, e[k - 1]);
        // The 2 x 2 block is rotated through its mean and half difference, so that an identity leaves it as
        // it is.
        const V difference = d[k + 1] - d[k], twice = e[k] + e[k];
        const V change = s * fma(s, difference, c * twice);
        d[k] += change;
        d[k + 1] -= change;
        e[k] = fma(c * s, difference, fma(-(s + s), s * e[k], e[k]));
        x = select(here | inside, e[k], splat(0.0));
        if (k + 1 < last) {
          z = s * e[k + 1];
          e[k + 1] *= c;
        }
        V* const upper = v + k * n;
        V* const lower = upper + n;
        for (int j = 0; j < n; ++j) {
          const V a = upper[j], b = lower[j];
          upper[j] = fma(c, a, s * b);
          lower[j] = fma(c, b, -(s * a));
        }
      }
    }
  }
}

// Replaces the full matrices a[n][n] of the lanes in `bits` by their projections (upper triangle).
template <int N>
void project_lanes(V* a, Size<N> size, uint32_t bits) {
  const int n = size.value();
  constexpr int kMax = capacity(N);
  // A power of two scales the largest entry to [1, 2), exactly.
  V largest = splat(0.0);
  for (int i = 0; i < n * n; ++i) largest = select(absolute(a[i]) > largest, absolute(a[i]), largest);
  const Mask regular = (largest > 1e-290) & (largest < 1e290);
  const V scale = select(regular, power_of_two_below(largest), splat(1.0)), inverse = splat(1.0) / scale;
  for (int i = 0; i < n * n; ++i) a[i] *= inverse;
  V d[kMax], e[kMax], v[kMax * kMax];
  tridiagonalize<N>(a, size, d, e, v);
  diagonalize<N>(d, e, v, size, lane_mask(bits) & (largest < 1e290));
  for (int i = 0; i < n; ++i)
    for (int j = i; j < n; ++j) a[i * n + j] = splat(0.0);
  for (int k = 0; k < n; ++k) {
    const V lambda = select(d[k] > 0.0, d[k], splat(0.0)) * scale;
    for (int i = 0; i < n; ++i) {
      const V scaled = lambda * v[k * n + i];
      for (int j = i; j < n; ++j) a[i * n + j] = fma(scaled, v[k * n + j], a[i * n + j]);
    }
  }
}

// Orthonormal basis of the vectors on the points that sum to zero (Helmert): row k - 1 is (1, .., 1, -k, 0,
// ..) over sqrt(k (k + 1)), with k ones.
constexpr double kRoots[] = {0.70710678118654752440, 0.40824829046386301637, 0.28867513459481288225,
                             0.22360679774997896964, 0.18257418583505537115};
constexpr double helmert(int k, int point) {
  return point < k ? kRoots[k - 1] : point == k ? -k * kRoots[k - 1] : 0.0;
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
void project_full(double* upper, Size<N> size, uint32_t bits) {
  const int n = size.value();
  constexpr int kMax = capacity(N);
  V a[kMax * kMax];
  load_full<N>(upper, n, a);
  project_lanes<N>(a, size, bits);
  store_selected<N>(upper, n, a, bits);
}

// The same on the n - 3 dimensions orthogonal to the translations.
template <int N>
void project_invariant(double* upper, uint32_t bits) {
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

}  // namespace

uint32_t psd_test(const double* upper, int n) {
  STARK_CHECK(n >= 1 && n <= kPsdMaxSize);
  switch (n) {
    case 3:
      return test_lanes<3>(upper, {n});
    case 6:
      return test_lanes<6>(upper, {n});
    case 9:
      return test_lanes<9>(upper, {n});
    case 12:
      return test_lanes<12>(upper, {n});
    case 15:
      return test_lanes<15>(upper, {n});
    case 18:
      return test_lanes<18>(upper, {n});
    default:
      return n <= kCommonSize ? test_lanes<0>(upper, {n}) : test_lanes<-1>(upper, {n});
  }
}

void psd_project(double* upper, int n, uint32_t mask, bool translation_invariant) {
  STARK_CHECK(n >= 1 && n <= kPsdMaxSize);
  STARK_CHECK(!translation_invariant || (n % 3 == 0 && n >= 6 && n <= kPsdMaxReduced));
  if (mask == 0) return;
  if (translation_invariant) {
    switch (n) {
      case 6:
        return project_invariant<6>(upper, mask);
      case 9:
        return project_invariant<9>(upper, mask);
      case 12:
        return project_invariant<12>(upper, mask);
      case 15:
        return project_invariant<15>(upper, mask);
      default:
        return project_invariant<18>(upper, mask);
    }
  }
  switch (n) {
    case 3:
      return project_full<3>(upper, {n}, mask);
    case 6:
      return project_full<6>(upper, {n}, mask);
    case 9:
      return project_full<9>(upper, {n}, mask);
    case 12:
      return project_full<12>(upper, {n}, mask);
    case 15:
      return project_full<15>(upper, {n}, mask);
    case 18:
      return project_full<18>(upper, {n}, mask);
    default:
      return n <= kCommonSize ? project_full<0>(upper, {n}, mask) : project_full<-1>(upper, {n}, mask);
  }
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
