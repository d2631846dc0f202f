// Small fixed-size vectors and matrices of doubles. Deliberately minimal: no expression templates, so that
// the same source compiles fast and gives the same bits on every compiler (contraction is off, see
// cmake/StarkOptions.cmake).
#pragma once

#include <array>
#include <cmath>
#include <cstddef>

namespace stark {

/// Vector in R^3.
struct Vec3 {
  double x = 0.0, y = 0.0, z = 0.0;

  constexpr double& operator[](int i) { return i == 0 ? x : (i == 1 ? y : z); }
  constexpr const double& operator[](int i) const { return i == 0 ? x : (i == 1 ? y : z); }
  constexpr Vec3& operator+=(const Vec3& b) {
    x += b.x;
    y += b.y;
    z += b.z;
    return *this;
  }
  constexpr Vec3& operator-=(const Vec3& b) {
    x -= b.x;
    y -= b.y;
    z -= b.z;
    return *this;
  }
  constexpr Vec3& operator*=(double s) {
    x *= s;
    y *= s;
    z *= s;
    return *this;
  }
  constexpr bool operator==(const Vec3&) const = default;
};
static_assert(sizeof(Vec3) == 3 * sizeof(double));

constexpr Vec3 operator+(Vec3 a, const Vec3& b) { return a += b; }
constexpr Vec3 operator-(Vec3 a, const Vec3& b) { return a -= b; }
constexpr Vec3 operator-(const Vec3& a) { return {-a.x, -a.y, -a.z}; }
constexpr Vec3 operator*(Vec3 a, double s) { return a *= s; }
constexpr Vec3 operator*(double s, Vec3 a) { return a *= s; }
constexpr Vec3 operator/(const Vec3& a, double s) { return {a.x / s, a.y / s, a.z / s}; }
constexpr double dot(const Vec3& a, const Vec3& b) { return a.x * b.x + a.y * b.y + a.z * b.z; }
constexpr Vec3 cross(const Vec3& a, const Vec3& b) {
  return {a.y * b.z - a.z * b.y, a.z * b.x - a.x * b.z, a.x * b.y - a.y * b.x};
}
constexpr double squared_norm(const Vec3& a) { return dot(a, a); }
inline double norm(const Vec3& a) { return std::sqrt(dot(a, a)); }
inline Vec3 normalized(const Vec3& a) { return a / norm(a); }
inline double max_abs(const Vec3& a) {
  return std::fmax(std::fabs(a.x), std::fmax(std::fabs(a.y), std::fabs(a.z)));
}
inline bool is_finite(const Vec3& a) {
  return std::isfinite(a.x) && std::isfinite(a.y) && std::isfinite(a.z);
}

/// 3x3 matrix, row-major.
struct Mat3 {
  std::array<double, 9> m{};

  constexpr double& operator()(int i, int j) { return m[3 * i + j]; }
  constexpr const double& operator()(int i, int j) const { return m[3 * i + j]; }
  constexpr Vec3 row(int i) const { return {m[3 * i], m[3 * i + 1], m[3 * i + 2]}; }
  constexpr Vec3 column(int j) const { return {m[j], m[3 + j], m[6 + j]}; }
  constexpr bool operator==(const Mat3&) const = default;

  static constexpr Mat3 identity() { return diagonal({1.0, 1.0, 1.0}); }
  static constexpr Mat3 diagonal(const Vec3& d) { return {{d.x, 0, 0, 0, d.y, 0, 0, 0, d.z}}; }
  static constexpr Mat3 from_columns(const Vec3& a, const Vec3& b, const Vec3& c) {
    return {{a.x, b.x, c.x, a.y, b.y, c.y, a.z, b.z, c.z}};
  }
};
static_assert(sizeof(Mat3) == 9 * sizeof(double));

constexpr Mat3& operator+=(Mat3& a, const Mat3& b) {
  for (int k = 0; k < 9; ++k) a.m[k] += b.m[k];
  return a;
}
constexpr Mat3 operator+(Mat3 a, const Mat3& b) { return a += b; }
constexpr Mat3 operator-(const Mat3& a, const Mat3& b) {
  Mat3 c;
  for (int k = 0; k < 9; ++k) c.m[k] = a.m[k] - b.m[k];
  return c;
}
constexpr Mat3 operator*(const Mat3& a, double s) {
  Mat3 c;
  for (int k = 0; k < 9; ++k) c.m[k] = a.m[k] * s;
  return c;
}
constexpr Mat3 operator*(double s, const Mat3& a) { return a * s; }
constexpr Vec3 operator*(const Mat3& a, const Vec3& v) {
  return {dot(a.row(0), v), dot(a.row(1), v), dot(a.row(2), v)};
}
constexpr Mat3 operator*(const Mat3& a, const Mat3& b) {
  Mat3 c;
  for (int i = 0; i < 3; ++i)
    for (int j = 0; j < 3; ++j) c(i, j) = a(i, 0) * b(0, j) + a(i, 1) * b(1, j) + a(i, 2) * b(2, j);
  return c;
}
constexpr Mat3 transpose(const Mat3& a) {
  return {{a.m[0], a.m[3], a.m[6], a.m[1], a.m[4], a.m[7], a.m[2], a.m[5], a.m[8]}};
}
constexpr double trace(const Mat3& a) { return a.m[0] + a.m[4] + a.m[8]; }
constexpr double determinant(const Mat3& a) { return dot(a.row(0), cross(a.row(1), a.row(2))); }
constexpr Mat3 outer(const Vec3& a, const Vec3& b) {
  return {
      {a.x * b.x, a.x * b.y, a.x * b.z, a.y * b.x, a.y * b.y, a.y * b.z, a.z * b.x, a.z * b.y, a.z * b.z}};
}
/// Matrix of the cross product: skew(a) b = a x b.
constexpr Mat3 skew(const Vec3& a) { return {{0, -a.z, a.y, a.z, 0, -a.x, -a.y, a.x, 0}}; }
constexpr Mat3 inverse(const Mat3& a) {
  const Vec3 c0 = cross(a.row(1), a.row(2)), c1 = cross(a.row(2), a.row(0)), c2 = cross(a.row(0), a.row(1));
  return Mat3::from_columns(c0, c1, c2) * (1.0 / dot(a.row(0), c0));
}

}  // namespace stark
