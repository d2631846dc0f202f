#include <stark/mechanics/element_evaluation.h>

#include <algorithm>
#include <string>

#include <stark/base/aligned.h>
#include <stark/base/error.h>

namespace stark {

using symbolic::kLanes;

namespace {

void check_count(const std::string& name, size_t got, size_t needed, const char* of) {
  if (got != needed)
    throw InvalidArgument(name + ": got " + std::to_string(got) + of + ": must be " + std::to_string(needed));
}

}  // namespace

ElementEvaluation evaluate_element(const Potential& potential, std::span<const Vec3> x,
                                   std::span<const Vec3> X, std::span<const Vec3> x_prev,
                                   const std::function<std::vector<double>(const ElementInput&)>& value) {
  const int count = potential.point_count(), n = 3 * count;
  check_count("x", x.size(), count, " points");
  check_count("X", X.size(), count, " points");
  check_count("x_prev", x_prev.size(), count, " points");
  const auto checked_value = [&](const auto& field) {
    std::vector<double> numbers = value({field.name, field.unit, field.doc, field.width});
    check_count("value '" + field.name + "'", numbers.size(), field.width, " numbers");
    return numbers;
  };
  // All lanes are the same element.
  AlignedVector<double> unknowns(n * kLanes), elements(potential.element_width() * kLanes + 1),
      uniforms(potential.uniform_width() + 1);
  const auto spread = [](AlignedVector<double>& lanes, int row, double number) {
    std::fill_n(lanes.begin() + row * kLanes, kLanes, number);
  };
  for (int i = 0; i < n; ++i) spread(unknowns, i, x[i / 3][i % 3]);
  for (const ElementField& field : potential.element_fields()) {
    std::vector<double> given;
    if (field.source == ElementField::Source::Data) {
      given = checked_value(field);
    } else {
      const Vec3& p = (field.source == ElementField::Source::Rest ? X : x_prev)[field.point];
      given = {p.x, p.y, p.z};
    }
    for (int c = 0; c < field.width; ++c) spread(elements, field.offset + c, given[c]);
  }
  for (const UniformField& field : potential.uniform_fields())
    std::ranges::copy(checked_value(field), uniforms.begin() + field.offset);
  AlignedVector<double> out(potential.kernel().output_count(symbolic::Order::Hessian) * kLanes);
  potential.kernel().evaluate(symbolic::Order::Hessian, unknowns.data(), elements.data(), uniforms.data(),
                              out.data(), 1);
  ElementEvaluation result{out[0], std::vector<Vec3>(count), std::vector<double>(n * n)};
  for (int i = 0; i < n; ++i) result.gradient[i / 3][i % 3] = out[(1 + i) * kLanes];
  for (int i = 0, k = 1 + n; i < n; ++i)
    for (int j = i; j < n; ++j, ++k) result.hessian[i * n + j] = result.hessian[j * n + i] = out[k * kLanes];
  return result;
}

}  // namespace stark
