// Compiled for processors with AVX-512 F function by function, so that the rest of the library runs without.
#include <stark/linalg/front_kernels_wide.h>

#if defined(__x86_64__)
#include <immintrin.h>

#define STARK_WIDE [[gnu::target("avx512f")]]
#define STARK_WIDE_INLINE [[gnu::target("avx512f"), gnu::always_inline]] inline

namespace stark::front {

namespace {

template <typename Real>
struct Wide;
template <>
struct Wide<double> {
  typedef __m512d V;
  STARK_WIDE_INLINE static V load(const double* p) { return _mm512_loadu_pd(p); }
  STARK_WIDE_INLINE static V join(const double* low, const double* high) {
    return __builtin_shufflevector(_mm256_loadu_pd(low), _mm256_loadu_pd(high), 0, 1, 2, 3, 4, 5, 6, 7);
  }
  STARK_WIDE_INLINE static void store(double* p, V v) { _mm512_storeu_pd(p, v); }
  STARK_WIDE_INLINE static void part(double* low, double* high, V v) {
    _mm256_storeu_pd(low, __builtin_shufflevector(v, v, 0, 1, 2, 3));
    _mm256_storeu_pd(high, __builtin_shufflevector(v, v, 4, 5, 6, 7));
  }
  STARK_WIDE_INLINE static V zero() { return _mm512_setzero_pd(); }
  STARK_WIDE_INLINE static V splat(double a) { return _mm512_set1_pd(a); }
  STARK_WIDE_INLINE static V fnma(V a, V b, V c) { return _mm512_fnmadd_pd(a, b, c); }
  STARK_WIDE_INLINE static V times(V a, V b) { return _mm512_mul_pd(a, b); }
};
template <>
struct Wide<float> {
  typedef __m512 V;
  STARK_WIDE_INLINE static V load(const float* p) { return _mm512_loadu_ps(p); }
  STARK_WIDE_INLINE static V join(const float* low, const float* high) {
    return __builtin_shufflevector(_mm256_loadu_ps(low), _mm256_loadu_ps(high), 0, 1, 2, 3, 4, 5, 6, 7, 8, 9,
                                   10, 11, 12, 13, 14, 15);
  }
  STARK_WIDE_INLINE static void store(float* p, V v) { _mm512_storeu_ps(p, v); }
  STARK_WIDE_INLINE static void part(float* low, float* high, V v) {
    _mm256_storeu_ps(low, __builtin_shufflevector(v, v, 0, 1, 2, 3, 4, 5, 6, 7));
    _mm256_storeu_ps(high, __builtin_shufflevector(v, v, 8, 9, 10, 11, 12, 13, 14, 15));
  }
  STARK_WIDE_INLINE static V zero() { return _mm512_setzero_ps(); }
  STARK_WIDE_INLINE static V splat(float a) { return _mm512_set1_ps(a); }
  STARK_WIDE_INLINE static V fnma(V a, V b, V c) { return _mm512_fnmadd_ps(a, b, c); }
  STARK_WIDE_INLINE static V times(V a, V b) { return _mm512_mul_ps(a, b); }
};

// A column of two strips of three half vectors each: the upper strip's first two halves, its last one with
// the lower strip's first, the lower strip's last two.
template <typename Real>
struct Column {
  using W = Wide<Real>;
  typename W::V v[3];

  STARK_WIDE_INLINE void load(const Real* upper, const Real* lower) {
    constexpr int kHalf = simd::kWidth<Real>;
    v[0] = W::load(upper), v[1] = W::join(upper + 2 * kHalf, lower), v[2] = W::load(lower + kHalf);
  }
  STARK_WIDE_INLINE void store(Real* upper, Real* lower) const {
    constexpr int kHalf = simd::kWidth<Real>;
    W::store(upper, v[0]), W::part(upper + 2 * kHalf, lower, v[1]), W::store(lower + kHalf, v[2]);
  }
  STARK_WIDE_INLINE void subtract(const Column& a, Real factor) {
    const auto s = W::splat(factor);
    for (int r = 0; r < 3; ++r) v[r] = W::fnma(a.v[r], s, v[r]);
  }
};

template <typename Real>
struct WideTile {
  Column<Real> c[kTile];

  STARK_WIDE_INLINE void clear() {
    for (auto& column : c)
      for (auto& v : column.v) v = Wide<Real>::zero();
  }
  STARK_WIDE_INLINE void load(StripPair<Real> t) {
    for (int j = 0; j < kTile; ++j) c[j].load(t.upper + j * kStrip<Real>, t.lower + j * kStrip<Real>);
  }
  STARK_WIDE_INLINE void store(StripPair<Real> t) const {
    for (int j = 0; j < kTile; ++j) c[j].store(t.upper + j * kStrip<Real>, t.lower + j * kStrip<Real>);
  }
  STARK_WIDE_INLINE void subtract_product(StripPair<const Real> a, const Real* b, int depth) {
    for (int k = 0; k < depth; ++k, a.upper += kStrip<Real>, a.lower += kStrip<Real>, b += kStrip<Real>) {
      Column<Real> column;
      column.load(a.upper, a.lower);
      for (int j = 0; j < kTile; ++j) c[j].subtract(column, b[j]);
    }
  }
  STARK_WIDE_INLINE void solve(const Real* l) {
    for (int j = 0; j < kTile; ++j) {
      for (int i = 0; i < j; ++i) c[j].subtract(c[i], l[i * kStrip<Real> + j]);
      const auto inverse = Wide<Real>::splat(l[j * kStrip<Real> + j]);
      for (auto& v : c[j].v) v = Wide<Real>::times(v, inverse);
    }
  }
};

template <typename Real>
STARK_WIDE_INLINE void subtract_product(StripPair<Real> t, StripPair<const Real> a, const Real* b, int depth,
                                        bool clear) {
  WideTile<Real> tile;
  if (clear) {
    tile.clear();
  } else {
    tile.load(t);
  }
  tile.subtract_product(a, b, depth);
  tile.store(t);
}

template <typename Real>
STARK_WIDE_INLINE void eliminate_tile(StripPair<Real> t, StripPair<const Real> a, const Real* b, int depth,
                                      const Real* l) {
  WideTile<Real> tile;
  tile.load(t);
  tile.subtract_product(a, b, depth);
  tile.solve(l);
  tile.store(t);
}

}  // namespace

STARK_WIDE void subtract_product_wide(StripPair<double> t, StripPair<const double> a, const double* b,
                                      int depth, bool clear) {
  subtract_product(t, a, b, depth, clear);
}
STARK_WIDE void subtract_product_wide(StripPair<float> t, StripPair<const float> a, const float* b, int depth,
                                      bool clear) {
  subtract_product(t, a, b, depth, clear);
}
STARK_WIDE void eliminate_tile_wide(StripPair<double> t, StripPair<const double> a, const double* b,
                                    int depth, const double* l) {
  eliminate_tile(t, a, b, depth, l);
}
STARK_WIDE void eliminate_tile_wide(StripPair<float> t, StripPair<const float> a, const float* b, int depth,
                                    const float* l) {
  eliminate_tile(t, a, b, depth, l);
}

}  // namespace stark::front

#else
namespace stark::front {

void subtract_product_wide(StripPair<double>, StripPair<const double>, const double*, int, bool) {}
void subtract_product_wide(StripPair<float>, StripPair<const float>, const float*, int, bool) {}
void eliminate_tile_wide(StripPair<double>, StripPair<const double>, const double*, int, const double*) {}
void eliminate_tile_wide(StripPair<float>, StripPair<const float>, const float*, int, const float*) {}

}  // namespace stark::front
#endif
