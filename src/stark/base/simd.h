// 256-bit vectors of double or float, on GCC's vector extensions: arithmetic operators work lane by lane.
// Fused multiply-adds are written out, so that the same source gives the same bits with and without hardware
// support.
#pragma once

#include <cmath>
#include <cstdint>
#include <cstring>

#if defined(__FMA__)
#include <immintrin.h>
#endif

namespace stark::simd {

template <typename Real>
struct Vector;
template <>
struct Vector<double> {
  typedef double type __attribute__((vector_size(32)));
  static constexpr int kWidth = 4;
};
template <>
struct Vector<float> {
  typedef float type __attribute__((vector_size(32)));
  static constexpr int kWidth = 8;
};

template <typename Real>
using V = typename Vector<Real>::type;
template <typename Real>
inline constexpr int kWidth = Vector<Real>::kWidth;

using VDouble = V<double>;
using VFloat = V<float>;
typedef int64_t MaskDouble __attribute__((vector_size(32)));  // all ones or all zeros per lane

inline VDouble load(const double* p) {
  VDouble v;
  std::memcpy(&v, p, sizeof(v));
  return v;
}
inline VFloat load(const float* p) {
  VFloat v;
  std::memcpy(&v, p, sizeof(v));
  return v;
}
inline void store(double* p, VDouble v) { std::memcpy(p, &v, sizeof(v)); }
inline void store(float* p, VFloat v) { std::memcpy(p, &v, sizeof(v)); }

inline VDouble splat(double a) { return VDouble{a, a, a, a}; }
inline VFloat splat(float a) { return VFloat{a, a, a, a, a, a, a, a}; }

/// a * b + c with one rounding.
inline VDouble fma(VDouble a, VDouble b, VDouble c) {
#if defined(__FMA__)
  return (VDouble)_mm256_fmadd_pd((__m256d)a, (__m256d)b, (__m256d)c);
#else
  for (int l = 0; l < 4; ++l) c[l] = std::fma(a[l], b[l], c[l]);
  return c;
#endif
}
inline VFloat fma(VFloat a, VFloat b, VFloat c) {
#if defined(__FMA__)
  return (VFloat)_mm256_fmadd_ps((__m256)a, (__m256)b, (__m256)c);
#else
  for (int l = 0; l < 8; ++l) c[l] = std::fma(a[l], b[l], c[l]);
  return c;
#endif
}

/// c - a * b with one rounding.
inline VDouble fnma(VDouble a, VDouble b, VDouble c) {
#if defined(__FMA__)
  return (VDouble)_mm256_fnmadd_pd((__m256d)a, (__m256d)b, (__m256d)c);
#else
  return fma(-a, b, c);
#endif
}
inline VFloat fnma(VFloat a, VFloat b, VFloat c) {
#if defined(__FMA__)
  return (VFloat)_mm256_fnmadd_ps((__m256)a, (__m256)b, (__m256)c);
#else
  return fma(-a, b, c);
#endif
}

inline VDouble sqrt(VDouble a) {
#if defined(__AVX__)
  return (VDouble)_mm256_sqrt_pd((__m256d)a);
#else
  for (int l = 0; l < 4; ++l) a[l] = std::sqrt(a[l]);
  return a;
#endif
}

inline VDouble absolute(VDouble a) { return a < 0.0 ? -a : a; }
inline VDouble select(MaskDouble mask, VDouble a, VDouble b) { return mask ? a : b; }

/// Sum of the lanes in a fixed order.
inline double sum(VDouble a) { return (a[0] + a[2]) + (a[1] + a[3]); }
inline float sum(VFloat a) { return ((a[0] + a[4]) + (a[2] + a[6])) + ((a[1] + a[5]) + (a[3] + a[7])); }

}  // namespace stark::simd
