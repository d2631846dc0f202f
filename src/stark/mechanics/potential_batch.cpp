#include <stark/mechanics/potential_batch.h>

#include <algorithm>

#include <stark/base/error.h>

namespace stark {

using symbolic::kLanes;

PotentialBatch::PotentialBatch(std::shared_ptr<const Potential> potential)
    : potential_(std::move(potential)) {
  uniforms_.assign(std::max(1, potential_->kernel().uniform_count()), 0.0);
  for (const UniformField& field : potential_->uniform_fields()) {
    if (field.name == "time_step") time_step_offset_ = field.offset;
    if (field.name == "time") time_offset_ = field.offset;
  }
}

void PotentialBatch::resize(std::span<const int32_t> stencils) {
  size_ = static_cast<int64_t>(stencils.size()) / point_count();
  stencils_.assign(stencils.begin(), stencils.end());
  elements_.assign(static_cast<size_t>(block_count()) * potential_->element_width() * kLanes, 0.0);
  resting_.clear();
  const auto& fields = potential_->element_fields();
  for (size_t k = 0; k < fields.size(); ++k)
    if (fields[k].source == ElementField::Source::Internal)
      for (int64_t e = 0; e < size_; ++e) set(static_cast<int>(k), e, fields[k].initial);
}

std::vector<double> PotentialBatch::internal_values() const {
  std::vector<double> values;
  const auto& fields = potential_->element_fields();
  values.reserve(static_cast<size_t>(size_) * potential_->internal_width());
  for (int64_t e = 0; potential_->internal_width() > 0 && e < size_; ++e)
    for (size_t k = 0; k < fields.size(); ++k)
      if (fields[k].source == ElementField::Source::Internal)
        for (int c = 0; c < fields[k].width; ++c) values.push_back(get(static_cast<int>(k), e, c));
  return values;
}

void PotentialBatch::set_internal(std::span<const double> values) {
  STARK_CHECK(static_cast<int64_t>(values.size()) == size_ * potential_->internal_width());
  const auto& fields = potential_->element_fields();
  for (int64_t e = 0; potential_->internal_width() > 0 && e < size_; ++e)
    for (size_t k = 0; k < fields.size(); ++k) {
      if (fields[k].source != ElementField::Source::Internal) continue;
      const auto width = static_cast<size_t>(fields[k].width);
      set(static_cast<int>(k), e, values.first(width));
      values = values.subspan(width);
    }
}

std::vector<double> PotentialBatch::updated_internal(std::span<const Vec3> x) const {
  return potential_->internal_width() > 0 ? evaluate(potential_->update(), x) : std::vector<double>();
}

void PotentialBatch::copy_padding(int64_t element, int offset) {
  // Lanes past the end repeat the last element, so that they never produce NaN.
  if (element != size_ - 1) return;
  double* last = lane(element, offset);
  for (int64_t l = element % kLanes + 1; l < kLanes; ++l) last[l - element % kLanes] = *last;
}

void PotentialBatch::set(int field, int64_t element, std::span<const double> values) {
  const ElementField& f = potential_->element_fields()[field];
  STARK_CHECK(static_cast<int>(values.size()) == f.width);
  double* const first = lane(element, f.offset);
  for (int c = 0; c < f.width; ++c) first[c * kLanes] = values[c];
  if (element < size_ - 1) return;
  for (int c = 0; c < f.width; ++c) copy_padding(element, f.offset + c);
}

double PotentialBatch::get(int field, int64_t element, int c) const {
  return *const_cast<PotentialBatch*>(this)->lane(element, potential_->element_fields()[field].offset + c);
}

void PotentialBatch::take(const PotentialBatch& from, std::span<const int64_t> elements) {
  STARK_CHECK(potential_ == from.potential_ && static_cast<int64_t>(elements.size()) == size_);
  uniforms_ = from.uniforms_;
  const int width = potential_->element_width();
  for (int64_t e = 0; e < size_; ++e)
    for (int k = 0; k < width; ++k) {
      *lane(e, k) = *const_cast<PotentialBatch&>(from).lane(elements[e], k);
      copy_padding(e, k);
    }
}

int PotentialBatch::field_index(const std::string& name) const {
  const auto& fields = potential_->element_fields();
  for (size_t k = 0; k < fields.size(); ++k)
    if (fields[k].name == name) return static_cast<int>(k);
  throw InternalError("potential '" + potential_->name() + "' has no element field '" + name + "'");
}

void PotentialBatch::set_resting(const std::function<bool(int64_t)>& rests) {
  resting_.assign(block_count(), 1);
  for (int64_t e = 0; e < size_; ++e)
    if (!rests(e)) resting_[e / kLanes] = 0;
}

void PotentialBatch::set_uniform(const std::string& name, std::span<const double> values) {
  for (const UniformField& field : potential_->uniform_fields())
    if (field.name == name) {
      STARK_CHECK(static_cast<int>(values.size()) == field.width);
      std::copy(values.begin(), values.end(), uniforms_.begin() + field.offset);
      return;
    }
  throw InternalError("potential '" + potential_->name() + "' has no parameter '" + name + "'");
}

void PotentialBatch::set_time(double h, double time) {
  if (time_step_offset_ >= 0) uniforms_[time_step_offset_] = h;
  if (time_offset_ >= 0) uniforms_[time_offset_] = time;
}

void PotentialBatch::fill(ElementField::Source source, std::span<const Vec3> values) {
  for (const ElementField& field : potential_->element_fields()) {
    if (field.source != source) continue;
    for (int64_t e = 0; e < size_; ++e) {
      const Vec3& v = values[stencils_[e * point_count() + field.point]];
      for (int c = 0; c < 3; ++c) *lane(e, field.offset + c) = v[c];
    }
    if (size_ > 0)
      for (int c = 0; c < 3; ++c) copy_padding(size_ - 1, field.offset + c);
  }
}

void PotentialBatch::set_rest(std::span<const Vec3> X) { fill(ElementField::Source::Rest, X); }

void PotentialBatch::set_previous(std::span<const Vec3> x_prev) {
  fill(ElementField::Source::Previous, x_prev);
  set_beyond(x_prev);
}

void PotentialBatch::set_beyond(std::span<const Vec3> x_beyond) {
  fill(ElementField::Source::Beyond, x_beyond);
}

void PotentialBatch::set_initial(std::span<const Vec3> x) { fill(ElementField::Source::Initial, x); }

void PotentialBatch::gather(std::span<const Vec3> x, int64_t first, int64_t last, double* lanes) const {
  const int points = point_count();
  for (int64_t block = first; block < last; ++block, lanes += 3 * points * kLanes)
    for (int l = 0; l < kLanes; ++l) {
      const int64_t element = std::min(block * kLanes + l, size_ - 1);
      const int32_t* sites = stencils_.data() + element * points;
      for (int p = 0; p < points; ++p) {
        const Vec3& position = x[sites[p]];
        lanes[(3 * p) * kLanes + l] = position.x;
        lanes[(3 * p + 1) * kLanes + l] = position.y;
        lanes[(3 * p + 2) * kLanes + l] = position.z;
      }
    }
}

void PotentialBatch::evaluate(symbolic::Order order, std::span<const Vec3> x, int64_t first, int64_t last,
                              double* out) const {
  thread_local ScratchBuffer<double> buffer;
  double* const unknowns = buffer.reserve(kGroupBlocks * 3 * point_count() * kLanes);
  const int outputs = potential_->kernel().output_count(order);
  for (int64_t group = first; group < last; group += kGroupBlocks) {
    const int64_t group_end = std::min(group + kGroupBlocks, last);
    gather(x, group, group_end, unknowns);
    for (int64_t run = group; run < group_end;) {
      const bool is_idle = rests(run);
      int64_t end = run + 1;
      while (end < group_end && rests(end) == is_idle) ++end;
      double* const of_run = out + (run - first) * outputs * kLanes;
      if (is_idle)
        std::fill_n(of_run, (end - run) * outputs * kLanes, 0.0);
      else
        evaluate_lanes(order, unknowns + (run - group) * 3 * point_count() * kLanes, run, end, of_run);
      run = end;
    }
  }
}

PotentialBatch::ActiveBlocks PotentialBatch::evaluate_active(symbolic::Order order, std::span<const Vec3> x,
                                                             int64_t first, int64_t last, double* out) const {
  STARK_CHECK(last - first <= kGroupBlocks);
  ActiveBlocks active;
  if (!potential_->is_one_sided()) {
    evaluate(order, x, first, last, out);
    for (int64_t block = first; block < last; ++block) active.blocks[active.count++] = block;
    return active;
  }
  thread_local ScratchBuffer<double> of_unknowns, of_energies;
  const int64_t width = static_cast<int64_t>(3) * point_count() * kLanes;
  double* const unknowns = of_unknowns.reserve(kGroupBlocks * width);
  double* const energies = of_energies.reserve(kGroupBlocks * kLanes);
  gather(x, first, last, unknowns);
  evaluate_lanes(symbolic::Order::Energy, unknowns, first, last, energies);
  const auto acts = [&](int64_t block) {  // energies that are not numbers count
    const double* lanes = energies + (block - first) * kLanes;
    return !std::all_of(lanes, lanes + kLanes, [](double energy) { return energy == 0.0; });
  };
  const int outputs = potential_->kernel().output_count(order);
  for (int64_t run = first; run < last;) {
    int64_t end = run;
    for (; end < last && acts(end); ++end) active.blocks[active.count++] = end;
    if (end > run)
      evaluate_lanes(order, unknowns + (run - first) * width, run, end,
                     out + (active.count - (end - run)) * outputs * kLanes);
    run = end + 1;
  }
  return active;
}

void PotentialBatch::evaluate_lanes(symbolic::Order order, const double* unknowns, int64_t first,
                                    int64_t last, double* out) const {
  potential_->kernel().evaluate(order, unknowns,
                                elements_.data() + first * potential_->element_width() * kLanes,
                                uniforms_.data(), out, last - first);
}

namespace {

/// Lanes as [element][output], without padding.
std::vector<double> by_element(std::span<const double> lanes, int64_t size, int outputs) {
  std::vector<double> result(static_cast<size_t>(size) * outputs);
  for (int64_t e = 0; e < size; ++e)
    for (int k = 0; k < outputs; ++k)
      result[e * outputs + k] = lanes[((e / kLanes) * outputs + k) * kLanes + e % kLanes];
  return result;
}

}  // namespace

PotentialBatch PotentialBatch::touching(std::span<const Vec3> x) const {
  PotentialBatch copy = *this;
  copy.touch(x);
  return copy;
}

std::vector<double> PotentialBatch::evaluate(symbolic::Order order, std::span<const Vec3> x) const {
  return potential_->totals() ? touching(x).evaluate_all(order, x) : evaluate_all(order, x);
}

std::vector<double> PotentialBatch::evaluate_all(symbolic::Order order, std::span<const Vec3> x) const {
  const int outputs = potential_->kernel().output_count(order);
  AlignedVector<double> lanes(static_cast<size_t>(block_count()) * outputs * kLanes);
  evaluate(order, x, 0, block_count(), lanes.data());
  return by_element(lanes, size_, outputs);
}

std::vector<double> PotentialBatch::evaluate(const symbolic::Function& function,
                                             std::span<const Vec3> x) const {
  const int outputs = function.output_count();
  AlignedVector<double> unknowns(static_cast<size_t>(block_count()) * 3 * point_count() * kLanes),
      lanes(static_cast<size_t>(block_count()) * outputs * kLanes);
  gather(x, 0, block_count(), unknowns.data());
  function.evaluate(unknowns.data(), elements_.data(), uniforms_.data(), lanes.data(), block_count());
  return by_element(lanes, size_, outputs);
}

}  // namespace stark
