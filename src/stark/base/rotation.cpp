#include <stark/base/rotation.h>

#include <algorithm>

namespace stark {

Mat3 exp_rotation(const Vec3& w) {
  const double theta2 = squared_norm(w), theta = std::sqrt(theta2);
  // Below 1e-4 rad the series are exact to rounding.
  const double a = theta < 1e-4 ? 1.0 - theta2 / 6.0 : std::sin(theta) / theta;
  const double half = std::sin(0.5 * theta);
  const double b = theta < 1e-4 ? 0.5 - theta2 / 24.0 : 2.0 * half * half / theta2;
  const Mat3 W = skew(w);
  return Mat3::identity() + W * a + (W * W) * b;
}

Vec3 log_rotation(const Mat3& R) {
  const Quaternion q = to_quaternion(R);
  const Vec3 v{q.x, q.y, q.z};
  const double s = norm(v);
  if (s < 1e-12) return v * 2.0;
  return v * (2.0 * std::atan2(s, q.w) / s);
}

Mat3 to_matrix(const Quaternion& q) {
  const double n = 1.0 / std::sqrt(q.w * q.w + q.x * q.x + q.y * q.y + q.z * q.z);
  const double w = q.w * n, x = q.x * n, y = q.y * n, z = q.z * n;
  return {{1 - 2 * (y * y + z * z), 2 * (x * y - w * z), 2 * (x * z + w * y), 2 * (x * y + w * z),
           1 - 2 * (x * x + z * z), 2 * (y * z - w * x), 2 * (x * z - w * y), 2 * (y * z + w * x),
           1 - 2 * (x * x + y * y)}};
}

Quaternion to_quaternion(const Mat3& R) {
  // Shepperd's method: the largest of the four components is computed first, so nothing cancels.
  const double t = trace(R);
  const std::array<double, 4> squares{t, R(0, 0), R(1, 1), R(2, 2)};
  const auto largest = std::max_element(squares.begin(), squares.end()) - squares.begin();
  Quaternion q;
  if (largest == 0) {
    q.w = 0.5 * std::sqrt(std::max(0.0, 1.0 + t));
    const double s = 0.25 / q.w;
    q.x = (R(2, 1) - R(1, 2)) * s;
    q.y = (R(0, 2) - R(2, 0)) * s;
    q.z = (R(1, 0) - R(0, 1)) * s;
  } else {
    const int i = static_cast<int>(largest) - 1, j = (i + 1) % 3, k = (i + 2) % 3;
    Vec3 v;
    v[i] = 0.5 * std::sqrt(std::max(0.0, 1.0 + R(i, i) - R(j, j) - R(k, k)));
    const double s = 0.25 / v[i];
    v[j] = (R(j, i) + R(i, j)) * s;
    v[k] = (R(k, i) + R(i, k)) * s;
    q = {(R(k, j) - R(j, k)) * s, v.x, v.y, v.z};
  }
  if (q.w < 0.0) q = {-q.w, -q.x, -q.y, -q.z};
  return q;
}

Mat3 orthonormalized(const Mat3& R) {
  const Vec3 a = normalized(R.column(0));
  const Vec3 b = normalized(R.column(1) - a * dot(a, R.column(1)));
  return Mat3::from_columns(a, b, cross(a, b));
}

Mat3 interpolate_rotation(const Mat3& A, const Mat3& B, double fraction) {
  return exp_rotation(log_rotation(B * transpose(A)) * fraction) * A;
}

}  // namespace stark
