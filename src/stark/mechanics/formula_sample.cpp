#include <stark/mechanics/formula_sample.h>

#include <numeric>
#include <string>
#include <utility>

#include <stark/base/aligned.h>
#include <stark/base/error.h>

namespace stark {

namespace {

PotentialBatch compiled(const Formula& formula, symbolic::Backend backend,
                        const std::vector<ParameterDeclaration>& fields) {
  const std::set<std::string> shared = formula.shared_parameters();
  std::set<std::string> names;
  for (const ParameterDeclaration& field : fields)
    if (!shared.contains(field.name)) names.insert(field.name);
  return PotentialBatch(
      std::make_shared<Potential>(define_potential("formula", "", formula), backend, names));
}

void check_points(const char* name, const std::vector<Vec3>& points, size_t count) {
  if (points.size() != count)
    throw InvalidArgument(std::string(name) + ": got " + std::to_string(points.size()) + " points: must be " +
                          std::to_string(count));
}

}  // namespace

FormulaSample::FormulaSample(const Formula& formula, symbolic::Backend backend, SamplePoints points,
                             const std::function<std::vector<double>(const ParameterDeclaration&)>& values)
    : batch_(compiled(formula, backend, parameters_of(formula))), x_(std::move(points.x)) {
  check_points("X", points.X, x_.size());
  check_points("x_prev", points.x_prev, x_.size());
  check_points("x_initial", points.x_initial, x_.size());
  std::vector<int32_t> stencils(x_.size());
  std::iota(stencils.begin(), stencils.end(), 0);
  batch_.resize(stencils);
  batch_.set_rest(points.X);
  batch_.set_previous(points.x_prev);
  batch_.set_initial(points.x_initial);
  batch_.set_time(points.time_step, points.time);
  const std::set<std::string> shared = formula.shared_parameters();
  for (const ParameterDeclaration& field : parameters_of(formula)) {
    const std::vector<double> numbers = values(field);
    const size_t width = field.width, count = width * batch_.size();
    if (numbers.size() != count)
      throw InvalidArgument(field.name + ": got " + std::to_string(numbers.size()) + " numbers: must be " +
                            std::to_string(count));
    if (shared.contains(field.name)) {
      batch_.set_uniform(field.name, std::span(numbers).first(width));
      continue;
    }
    for (int64_t e = 0; e < batch_.size(); ++e)
      batch_.set(field.name, e, std::span(numbers).subspan(e * width, width));
  }
}

void FormulaSample::set_positions(std::vector<Vec3> x) {
  check_points("x", x, x_.size());
  x_ = std::move(x);
}

void FormulaSample::run(symbolic::Order order) const {
  const int outputs = batch_.potential().kernel().output_count(order);
  AlignedVector<double> lanes(static_cast<size_t>(batch_.block_count()) * outputs * symbolic::kLanes);
  batch_.evaluate(order, x_, 0, batch_.block_count(), lanes.data());
}

}  // namespace stark
