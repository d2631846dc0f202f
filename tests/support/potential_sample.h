// Inputs for one element of a potential: what its definition samples, completed with the defaults that
// mechanics/potential.h documents, and evaluation of that element at positions of choice.
#pragma once

#include <array>
#include <random>
#include <vector>

#include <stark/base/aligned.h>
#include <stark/base/math.h>
#include <stark/base/rotation.h>
#include <stark/mechanics/potential.h>

namespace stark::test {

/// One element with everything that its kernel needs.
struct FilledSample {
  std::vector<Vec3> X, x_prev, x;                     ///< [m] by point
  std::map<std::string, std::vector<double>> values;  ///< data and parameters by name
};

inline double uniform(std::mt19937_64& random, double low, double high) {
  return std::uniform_real_distribution<double>(low, high)(random);
}

inline Vec3 random_vector(std::mt19937_64& random, double size) {
  const double x = uniform(random, -size, size), y = uniform(random, -size, size);
  return {x, y, uniform(random, -size, size)};
}

/// Completes the definition's sample: a well-shaped simplex of about 1 m, moved and strained by up to 20 %,
/// and numbers in [0.5, 1.5].
inline FilledSample fill_sample(const PotentialDefinition& definition, const Potential& potential,
                                std::mt19937_64& random) {
  const PotentialSample given = definition.sample ? definition.sample(random) : PotentialSample{};
  const std::array<Vec3, 4> simplex{Vec3{0, 0, 0}, Vec3{1, 0, 0}, Vec3{0.5, 0.9, 0}, Vec3{0.5, 0.3, 0.8}};
  FilledSample sample{given.X, given.x_prev, given.x, given.values};
  if (sample.X.empty())
    for (int p = 0; p < definition.point_count; ++p)
      sample.X.push_back((p < 4 ? simplex[p] : random_vector(random, 1.0)) + random_vector(random, 0.1));
  // Rotation after strain: x = R (1 + S) X + t with |S| of 20 % at most in the Frobenius norm.
  const auto deformed = [&] {
    Mat3 S;
    for (int i = 0; i < 3; ++i)
      for (int j = i; j < 3; ++j) S(i, j) = S(j, i) = uniform(random, -0.2, 0.2) / 3.0;
    const Mat3 F = exp_rotation(random_vector(random, 1.0)) * (Mat3::identity() + S);
    const Vec3 shift = random_vector(random, 0.5);
    std::vector<Vec3> x;
    for (const Vec3& X : sample.X) x.push_back(F * X + shift);
    return x;
  };
  if (sample.x_prev.empty()) sample.x_prev = deformed();
  if (sample.x.empty()) sample.x = deformed();
  const auto fill = [&](const std::string& name, int width) {
    std::vector<double>& numbers = sample.values[name];
    while (static_cast<int>(numbers.size()) < width) numbers.push_back(uniform(random, 0.5, 1.5));
  };
  for (const ElementField& field : potential.element_fields())
    if (field.source == ElementField::Source::Data) fill(field.name, field.width);
  for (const UniformField& field : potential.uniform_fields()) fill(field.name, field.width);
  return sample;
}

/// Writes the sample, with points at x, into all lanes of one block of each kind of input.
inline void fill_inputs(const Potential& potential, const FilledSample& sample, const std::vector<Vec3>& x,
                        double* unknowns, double* elements, double* uniforms) {
  using symbolic::kLanes;
  const auto spread = [](double* array, int row, double value) {
    for (int l = 0; l < kLanes; ++l) array[row * kLanes + l] = value;
  };
  for (int p = 0; p < potential.point_count(); ++p)
    for (int c = 0; c < 3; ++c) spread(unknowns, 3 * p + c, x[p][c]);
  for (const ElementField& field : potential.element_fields())
    for (int c = 0; c < field.width; ++c) {
      double value = 0.0;
      switch (field.source) {
        case ElementField::Source::Data:
          value = sample.values.at(field.name)[c];
          break;
        case ElementField::Source::Rest:
          value = sample.X[field.point][c];
          break;
        case ElementField::Source::Previous:
        case ElementField::Source::Beyond:
        case ElementField::Source::Initial:
          value = sample.x_prev[field.point][c];
          break;
        case ElementField::Source::Internal:
          value = field.initial[c];
          break;
      }
      spread(elements, field.offset + c, value);
    }
  for (const UniformField& field : potential.uniform_fields())
    for (int c = 0; c < field.width; ++c) uniforms[field.offset + c] = sample.values.at(field.name)[c];
}

/// All outputs of a kernel for one element: energy, gradient, upper triangle of the Hessian.
inline std::vector<double> evaluate(const Potential& potential, const FilledSample& sample,
                                    symbolic::Order order, const std::vector<Vec3>& x) {
  using symbolic::kLanes;
  const symbolic::Kernel& kernel = potential.kernel();
  AlignedVector<double> unknowns(kernel.unknown_count() * kLanes),
      elements(potential.element_width() * kLanes + 1), uniforms(potential.uniform_width() + 1),
      out(kernel.output_count(order) * kLanes);
  fill_inputs(potential, sample, x, unknowns.data(), elements.data(), uniforms.data());
  kernel.evaluate(order, unknowns.data(), elements.data(), uniforms.data(), out.data(), 1);
  std::vector<double> result;
  for (int k = 0; k < kernel.output_count(order); ++k) result.push_back(out[k * kLanes]);
  return result;
}

inline double energy(const Potential& potential, const FilledSample& sample, const std::vector<Vec3>& x) {
  return evaluate(potential, sample, symbolic::Order::Energy, x)[0];
}

/// Gradient [N], three numbers a point.
inline std::vector<double> gradient(const Potential& potential, const FilledSample& sample,
                                    const std::vector<Vec3>& x) {
  const std::vector<double> out = evaluate(potential, sample, symbolic::Order::Gradient, x);
  return {out.begin() + 1, out.end()};
}

/// Hessian [N/m] as a dense row-major matrix.
inline std::vector<double> hessian(const Potential& potential, const FilledSample& sample,
                                   const std::vector<Vec3>& x) {
  const std::vector<double> out = evaluate(potential, sample, symbolic::Order::Hessian, x);
  const int n = 3 * potential.point_count();
  std::vector<double> H(n * n);
  int k = 1 + n;
  for (int i = 0; i < n; ++i)
    for (int j = i; j < n; ++j) H[i * n + j] = H[j * n + i] = out[k++];
  return H;
}

}  // namespace stark::test
