// Small vectors and matrices of symbolic scalars: a thin layer that only builds scalar expressions.
// Phase: model building.
#pragma once

#include <stark/symbolic/expr.h>

#include <array>
#include <concepts>

namespace stark::symbolic {

/// Vector of N scalars.
template <int N>
struct Vec {
  std::array<Scalar, N> v{};

  Vec() = default;
  template <typename... S>
    requires(sizeof...(S) == N && N > 1 && (std::convertible_to<S, Scalar> && ...))
  Vec(const S&... s) : v{Scalar(s)...} {}

  Scalar& operator[](int i) { return v[i]; }
  const Scalar& operator[](int i) const { return v[i]; }
  Scalar& operator()(int i) { return v[i]; }
  const Scalar& operator()(int i) const { return v[i]; }
  const Scalar& x() const { return v[0]; }
  const Scalar& y() const
    requires(N >= 2)
  {
    return v[1];
  }
  const Scalar& z() const
    requires(N >= 3)
  {
    return v[2];
  }
  static constexpr int size() { return N; }

  friend Vec operator+(Vec a, const Vec& b) { return a += b; }
  friend Vec operator-(Vec a, const Vec& b) { return a -= b; }
  friend Vec operator*(Vec a, const Scalar& s) { return a *= s; }
  friend Vec operator*(const Scalar& s, Vec a) { return a *= s; }
  friend Vec operator/(Vec a, const Scalar& s) { return a /= s; }
  friend Vec operator-(Vec a) {
    for (auto& x : a.v) x = -x;
    return a;
  }
  Vec& operator+=(const Vec& b) {
    for (int i = 0; i < N; ++i) v[i] += b.v[i];
    return *this;
  }
  Vec& operator-=(const Vec& b) {
    for (int i = 0; i < N; ++i) v[i] -= b.v[i];
    return *this;
  }
  Vec& operator*=(const Scalar& s) {
    for (auto& x : v) x *= s;
    return *this;
  }
  Vec& operator/=(const Scalar& s) {
    for (auto& x : v) x /= s;
    return *this;
  }
};
using Vec2 = Vec<2>;
using Vec3 = Vec<3>;
using Vec4 = Vec<4>;

/// Matrix of R rows and C columns; the constructor takes the entries row by row.
template <int R, int C>
struct Mat {
  std::array<Scalar, R * C> m{};

  Mat() = default;
  template <typename... S>
    requires(sizeof...(S) == R * C && R * C > 1 && (std::convertible_to<S, Scalar> && ...))
  Mat(const S&... s) : m{Scalar(s)...} {}

  Scalar& operator()(int i, int j) { return m[i * C + j]; }
  const Scalar& operator()(int i, int j) const { return m[i * C + j]; }
  static constexpr int rows() { return R; }
  static constexpr int columns() { return C; }
  Vec<C> row(int i) const {
    Vec<C> r;
    for (int j = 0; j < C; ++j) r[j] = (*this)(i, j);
    return r;
  }
  Vec<R> column(int j) const {
    Vec<R> c;
    for (int i = 0; i < R; ++i) c[i] = (*this)(i, j);
    return c;
  }
  void set_row(int i, const Vec<C>& r) {
    for (int j = 0; j < C; ++j) (*this)(i, j) = r[j];
  }
  void set_column(int j, const Vec<R>& c) {
    for (int i = 0; i < R; ++i) (*this)(i, j) = c[i];
  }
  static Mat identity()
    requires(R == C)
  {
    Mat a;
    for (int i = 0; i < R; ++i) a(i, i) = 1.0;
    return a;
  }
  static Mat diagonal(const Vec<R>& d)
    requires(R == C)
  {
    Mat a;
    for (int i = 0; i < R; ++i) a(i, i) = d[i];
    return a;
  }
  template <typename... V>
    requires(sizeof...(V) == C && (std::same_as<V, Vec<R>> && ...))
  static Mat from_columns(const V&... columns) {
    Mat a;
    int j = 0;
    (a.set_column(j++, columns), ...);
    return a;
  }
  template <typename... V>
    requires(sizeof...(V) == R && (std::same_as<V, Vec<C>> && ...))
  static Mat from_rows(const V&... rows) {
    Mat a;
    int i = 0;
    (a.set_row(i++, rows), ...);
    return a;
  }

  friend Mat operator+(Mat a, const Mat& b) { return a += b; }
  friend Mat operator-(Mat a, const Mat& b) { return a -= b; }
  friend Mat operator*(Mat a, const Scalar& s) { return a *= s; }
  friend Mat operator*(const Scalar& s, Mat a) { return a *= s; }
  friend Mat operator/(Mat a, const Scalar& s) { return a /= s; }
  friend Mat operator-(Mat a) {
    for (auto& x : a.m) x = -x;
    return a;
  }
  Mat& operator+=(const Mat& b) {
    for (int k = 0; k < R * C; ++k) m[k] += b.m[k];
    return *this;
  }
  Mat& operator-=(const Mat& b) {
    for (int k = 0; k < R * C; ++k) m[k] -= b.m[k];
    return *this;
  }
  Mat& operator*=(const Scalar& s) {
    for (auto& x : m) x *= s;
    return *this;
  }
  Mat& operator/=(const Scalar& s) {
    for (auto& x : m) x /= s;
    return *this;
  }
};
using Mat2 = Mat<2, 2>;
using Mat3 = Mat<3, 3>;
using Mat32 = Mat<3, 2>;
using Mat23 = Mat<2, 3>;
using Mat4 = Mat<4, 4>;

template <int N>
Scalar dot(const Vec<N>& a, const Vec<N>& b) {
  Scalar s = a[0] * b[0];
  for (int i = 1; i < N; ++i) s += a[i] * b[i];
  return s;
}
template <int N>
Scalar squared_norm(const Vec<N>& a) {
  return dot(a, a);
}
template <int N>
Scalar norm(const Vec<N>& a) {
  return sqrt(dot(a, a));
}
template <int N>
Vec<N> normalized(const Vec<N>& a) {
  return a / norm(a);
}
inline Vec3 cross(const Vec3& a, const Vec3& b) {
  return {a[1] * b[2] - a[2] * b[1], a[2] * b[0] - a[0] * b[2], a[0] * b[1] - a[1] * b[0]};
}
inline Scalar cross(const Vec2& a, const Vec2& b) { return a[0] * b[1] - a[1] * b[0]; }
template <int R, int C>
Mat<R, C> outer(const Vec<R>& a, const Vec<C>& b) {
  Mat<R, C> m;
  for (int i = 0; i < R; ++i)
    for (int j = 0; j < C; ++j) m(i, j) = a[i] * b[j];
  return m;
}
/// Matrix of the cross product: skew(a) b = a x b.
inline Mat3 skew(const Vec3& a) { return {0.0, -a[2], a[1], a[2], 0.0, -a[0], -a[1], a[0], 0.0}; }
template <int N>
Vec<N> select(const Scalar& condition, const Vec<N>& a, const Vec<N>& b) {
  Vec<N> r;
  for (int i = 0; i < N; ++i) r[i] = select(condition, a[i], b[i]);
  return r;
}

template <int R, int C>
Vec<R> operator*(const Mat<R, C>& a, const Vec<C>& v) {
  Vec<R> r;
  for (int i = 0; i < R; ++i) r[i] = dot(a.row(i), v);
  return r;
}
template <int R, int K, int C>
Mat<R, C> operator*(const Mat<R, K>& a, const Mat<K, C>& b) {
  Mat<R, C> m;
  for (int i = 0; i < R; ++i)
    for (int j = 0; j < C; ++j) m(i, j) = dot(a.row(i), b.column(j));
  return m;
}
template <int R, int C>
Mat<C, R> transpose(const Mat<R, C>& a) {
  Mat<C, R> t;
  for (int i = 0; i < R; ++i)
    for (int j = 0; j < C; ++j) t(j, i) = a(i, j);
  return t;
}
template <int R, int C>
Scalar squared_norm(const Mat<R, C>& a) {
  Scalar s = a.m[0] * a.m[0];
  for (int k = 1; k < R * C; ++k) s += a.m[k] * a.m[k];
  return s;
}
template <int N>
Scalar trace(const Mat<N, N>& a) {
  Scalar s = a(0, 0);
  for (int i = 1; i < N; ++i) s += a(i, i);
  return s;
}
inline Scalar determinant(const Mat2& a) { return a(0, 0) * a(1, 1) - a(0, 1) * a(1, 0); }
inline Scalar determinant(const Mat3& a) { return dot(a.column(0), cross(a.column(1), a.column(2))); }
inline Mat2 inverse(const Mat2& a) {
  return Mat2(a(1, 1), -a(0, 1), -a(1, 0), a(0, 0)) * (1.0 / determinant(a));
}
inline Mat3 inverse(const Mat3& a) {
  const Vec3 r0 = cross(a.column(1), a.column(2));
  const Vec3 r1 = cross(a.column(2), a.column(0));
  const Vec3 r2 = cross(a.column(0), a.column(1));
  return Mat3::from_rows(r0, r1, r2) * (1.0 / dot(a.column(0), r0));
}

/// N new inputs in a row.
template <int N>
Vec<N> input_vector(Graph& graph, InputKind kind) {
  Vec<N> r;
  for (auto& x : r.v) x = graph.input(kind);
  return r;
}
/// R x C new inputs, row by row.
template <int R, int C>
Mat<R, C> input_matrix(Graph& graph, InputKind kind) {
  Mat<R, C> r;
  for (auto& x : r.m) x = graph.input(kind);
  return r;
}
template <int N>
void mark_stage(Graph& graph, const Vec<N>& a) {
  for (const auto& x : a.v) graph.mark_stage(x);
}
template <int R, int C>
void mark_stage(Graph& graph, const Mat<R, C>& a) {
  for (const auto& x : a.m) graph.mark_stage(x);
}

}  // namespace stark::symbolic
