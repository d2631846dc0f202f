// Least squares with coefficients that are not negative. Used while a model is built.
#pragma once

#include <span>
#include <vector>

namespace stark {

/// Coefficients c >= 0 that minimise |sum_k c_k a_k - b|; `columns` has the vectors a_k one after the other,
/// as long as b. Those that are positive are of linearly independent vectors, so at most b.size() are.
/// `start`: such coefficients that are nearly right; empty: none. [Lawson, Hanson 1974, chapter 23]
std::vector<double> nonnegative_fit(std::span<const double> columns, std::span<const double> b,
                                    std::vector<double> start = {});

}  // namespace stark
