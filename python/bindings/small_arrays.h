// Vectors and matrices of three from and to NumPy.
#pragma once

#include <algorithm>
#include <string>
#include <vector>

#include "arrays.h"

namespace stark::bindings {

inline Vec3 vector_of(nb::handle object, const std::string& name) {
  const auto column = array<Column<double>>(object, name, "three numbers");
  if (column.shape(0) != 3)
    throw InvalidArgument(name + ": got " + std::to_string(column.shape(0)) + " numbers, need three numbers");
  return {column(0), column(1), column(2)};
}

inline Mat3 matrix_of(nb::handle object, const std::string& name,
                      const std::string& what = "a 3 x 3 rotation matrix") {
  const auto matrix = array<Rows<double, 3>>(object, name, what);
  if (matrix.shape(0) != 3)
    throw InvalidArgument(name + ": got " + std::to_string(matrix.shape(0)) + " rows, need " + what);
  Mat3 result;
  std::copy_n(matrix.data(), 9, result.m.begin());
  return result;
}

inline std::vector<Vec3> points_of(nb::handle object, const std::string& name) {
  const auto array_of = array<Rows<double, 3>>(object, name, "an array of shape (n, 3) of real numbers [m]");
  const auto view = rows<Vec3>(array_of);
  return {view.begin(), view.end()};
}

inline auto vector_to_numpy(const Vec3& v) { return to_numpy<double>(std::vector<double>{v.x, v.y, v.z}); }

/// As a (3, 3) array.
inline auto matrix_to_numpy(const Mat3& m) {
  return to_numpy<double>(std::vector<Vec3>{m.row(0), m.row(1), m.row(2)});
}

}  // namespace stark::bindings
