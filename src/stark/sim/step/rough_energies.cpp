#include <stark/sim/step/rough_energies.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <limits>

namespace stark {

namespace {

/// Forces out of balance over the largest of them, and jumps over what is out of balance, from which they
/// count.
constexpr double kPart = 0.1;
/// Gauss-Legendre quadrature on [-1, 1].
constexpr std::array<double, 4> kPlaces{-0.8611363115940526, -0.3399810435848563, 0.3399810435848563,
                                        0.8611363115940526};
constexpr std::array<double, 4> kWeights{0.3478548451374538, 0.6521451548625461, 0.6521451548625461,
                                         0.3478548451374538};
/// Ways are cut here, not in their middle, where the step stands, so often.
constexpr double kCut = 0.47;
constexpr int kCuts = 28;
constexpr size_t kTried = 3;  ///< elements whose ways are cut
/// Of an energy and of what its derivatives make of places, what rounding may change.
constexpr double kRounding = 8.0 * std::numeric_limits<double>::epsilon();

/// What is out of balance: blocks, and the largest force [N].
struct Unbalanced {
  std::vector<char> blocks;
  std::vector<BodyVertices> owners;
  double force = 0.0;
};

Unbalanced unbalanced(const FailedStep& step, std::span<const double> gradient) {
  Unbalanced result;
  result.owners = block_owners(step.scene, step.model);
  result.blocks.assign(result.owners.size(), 0);
  std::vector<double> forces;
  for (size_t b = 0; b < result.owners.size(); ++b)
    forces.push_back(norm({gradient[3 * b], gradient[3 * b + 1], gradient[3 * b + 2]}) *
                     step.model.block_scales()[b].inverse_length);
  for (const double force : forces) result.force = std::fmax(result.force, force);
  for (size_t b = 0; b < forces.size(); ++b) result.blocks[b] = forces[b] >= kPart * result.force ? 1 : 0;
  return result;
}

/// A block that is out of balance among those that a site hangs on, kNoBlock without one.
int32_t block_of(const FailedStep& step, const Unbalanced& loads, int32_t site) {
  const SiteJacobian jacobian = step.model.map().jacobian(site, step.potential.configuration());
  const auto counts = [&](int32_t block) { return block != kNoBlock && loads.blocks[block] != 0; };
  for (int k = 0; k < jacobian.term_count; ++k)
    if (counts(jacobian.terms[k].block)) return jacobian.terms[k].block;
  for (const int32_t block : jacobian.support_blocks)
    if (counts(block)) return block;
  return kNoBlock;
}

int32_t block_of_element(const FailedStep& step, const Unbalanced& loads, const PotentialBatch& batch,
                         int64_t element) {
  for (const int32_t site : batch.stencil(element))
    if (const int32_t block = block_of(step, loads, site); block != kNoBlock) return block;
  return kNoBlock;
}

/// What is left of a change of an element beyond the integral of its derivatives, and beyond rounding.
struct Jump {
  double energy = 0.0;  ///< [J]
  double force = 0.0;   ///< [N] the largest on a point
};

/// Straight ways of the points of a batch, x + t d.
class Ways {
 public:
  Ways(const PotentialBatch& batch, std::span<const Vec3> x, std::span<const Vec3> d)
      : batch_(batch), x_(x), d_(d), y_(x.begin(), x.end()) {}

  std::vector<Jump> jumps(std::span<const int64_t> elements, double begin, double end) {
    const int n = 3 * batch_.point_count();
    std::vector<std::vector<double>> rest(elements.size(), std::vector<double>(1 + n)), rounding = rest;
    const auto add = [&](double t, double of_values, double of_slopes) {
      const std::vector<double> values = outputs(t);
      for (size_t k = 0; k < elements.size(); ++k) {
        add_element(elements[k], values, of_values, of_slopes, rest[k]);
        if (of_values != 0.0) add_rounding(elements[k], values, rounding[k]);
      }
    };
    add(end, 1.0, 0.0);
    add(begin, -1.0, 0.0);
    const double half = 0.5 * (end - begin);
    for (size_t k = 0; k < kPlaces.size(); ++k)
      add(begin + half * (1.0 + kPlaces[k]), 0.0, -half * kWeights[k]);
    std::vector<Jump> found;
    for (size_t k = 0; k < elements.size(); ++k) {
      std::vector<double>& r = rest[k];
      for (int i = 0; i <= n; ++i) r[i] = std::fmax(std::fabs(r[i]) - rounding[k][i], 0.0);
      Jump jump{.energy = r[0]};
      for (int p = 1; p < n; p += 3) jump.force = std::fmax(jump.force, norm({r[p], r[p + 1], r[p + 2]}));
      found.push_back(jump);
    }
    return found;
  }

  /// What jumps within [-1, 1], of energies or of forces: there kinks lose what they hide, jumps keep it.
  Jump narrowed(int64_t element, double Jump::* size) {
    double begin = -1.0, end = 1.0;
    const std::array<int64_t, 1> one{element};
    for (int k = 0; k < kCuts; ++k) {
      const double cut = begin + kCut * (end - begin);
      const bool left = jumps(one, begin, cut)[0].*size >= jumps(one, cut, end)[0].*size;
      (left ? end : begin) = cut;
    }
    return jumps(one, begin, end)[0];
  }

  /// Largest motion of a point of the element [m].
  double length(int64_t element) const {
    double longest = 0.0;
    for (const int32_t site : batch_.stencil(element)) longest = std::max(longest, norm(d_[site]));
    return longest;
  }

 private:
  std::vector<double> outputs(double t) {
    for (size_t i = 0; i < y_.size(); ++i) y_[i] = x_[i] + d_[i] * t;
    return batch_.evaluate(symbolic::Order::Hessian, y_);
  }

  /// Adds energy and gradient, and their derivatives by t, with these factors.
  void add_element(int64_t element, std::span<const double> values, double of_values, double of_slopes,
                   std::vector<double>& sum) const {
    const int n = 3 * batch_.point_count();
    const size_t width = values.size() / static_cast<size_t>(batch_.size());
    const double* out = values.data() + static_cast<size_t>(element) * width;
    const std::span<const int32_t> sites = batch_.stencil(element);
    for (int i = 0; i <= n; ++i) sum[i] += of_values * out[i];
    for (int i = 0, k = 1 + n; i < n; ++i) {
      sum[0] += of_slopes * out[1 + i] * d_[sites[i / 3]][i % 3];
      for (int j = i; j < n; ++j, ++k) {
        sum[1 + i] += of_slopes * out[k] * d_[sites[j / 3]][j % 3];
        if (j > i) sum[1 + j] += of_slopes * out[k] * d_[sites[i / 3]][i % 3];
      }
    }
  }

  /// Adds what rounding of energy, gradient and places may change energy and gradient by.
  void add_rounding(int64_t element, std::span<const double> values, std::vector<double>& sum) const {
    const int n = 3 * batch_.point_count();
    const size_t width = values.size() / static_cast<size_t>(batch_.size());
    const double* out = values.data() + static_cast<size_t>(element) * width;
    const std::span<const int32_t> sites = batch_.stencil(element);
    const auto place = [&](int i) { return std::fabs(y_[sites[i / 3]][i % 3]); };
    for (int i = 0; i <= n; ++i) sum[i] += kRounding * std::fabs(out[i]);
    for (int i = 0, k = 1 + n; i < n; ++i) {
      sum[0] += kRounding * std::fabs(out[1 + i]) * place(i);
      for (int j = i; j < n; ++j, ++k) {
        sum[1 + i] += kRounding * std::fabs(out[k]) * place(j);
        if (j > i) sum[1 + j] += kRounding * std::fabs(out[k]) * place(i);
      }
    }
  }

  const PotentialBatch& batch_;
  std::span<const Vec3> x_, d_;
  std::vector<Vec3> y_;
};

/// Elements that act on what is out of balance, those first whose changes are explained least.
std::vector<int64_t> least_explained(const std::vector<int64_t>& acting, const std::vector<Jump>& jumps,
                                     double Jump::* size) {
  std::vector<size_t> order(acting.size());
  for (size_t k = 0; k < order.size(); ++k) order[k] = k;
  std::ranges::stable_sort(order, std::greater<>{}, [&](size_t k) { return jumps[k].*size; });
  std::vector<int64_t> result;
  for (size_t k = 0; k < std::min(kTried, order.size()); ++k) result.push_back(acting[order[k]]);
  return result;
}

/// The larger of what is known and of what the energy `owner` has on these ways.
void add_rough(const FailedStep& step, const Unbalanced& loads, const ModelBatch& energy,
               std::span<const Vec3> d, std::optional<RoughEnergy>& found) {
  const PotentialBatch& batch = energy.batch;
  if (batch.potential().totals()) return;  // elements have no energy of their own
  std::vector<int64_t> acting;
  for (int64_t e = 0; e < batch.size(); ++e)
    if (block_of_element(step, loads, batch, e) != kNoBlock) acting.push_back(e);
  if (acting.empty()) return;
  Ways ways(batch, step.potential.site_positions(), d);
  const std::vector<Jump> whole = ways.jumps(acting, -1.0, 1.0);
  for (double Jump::* size : {&Jump::energy, &Jump::force})
    for (const int64_t e : least_explained(acting, whole, size)) {
      const Jump jump = ways.narrowed(e, size);
      const bool is_jump = size == &Jump::energy && jump.energy > kPart * loads.force * ways.length(e);
      const bool is_kink = size == &Jump::force && jump.force > kPart * loads.force;
      if (!is_jump && (!is_kink || (found && (found->jump > 0.0 || found->force >= jump.force)))) continue;
      if (is_jump && found && found->jump >= jump.energy) continue;
      const int32_t block = block_of_element(step, loads, batch, e);
      found = RoughEnergy{loads.owners[block], energy.owner, is_jump ? jump.energy : 0.0, jump.force};
    }
}

/// Ways to look for kinks along: the last Newton step, and the motion of the step.
std::vector<std::vector<Vec3>> directions(const FailedStep& step) {
  const std::span<const Vec3> x = step.potential.site_positions();
  std::vector<std::vector<Vec3>> all;
  const auto finite = [](const std::vector<Vec3>& d) {
    return std::ranges::all_of(d, [](const Vec3& v) { return is_finite(v); });
  };
  std::vector<Vec3> d(x.size());
  if (!step.direction.empty() &&
      std::ranges::all_of(step.direction, [](double v) { return std::isfinite(v); })) {
    const std::vector<Vec3> end =
        step.potential.positions_along(step.direction, step.settings.newton.max_rotation);
    for (size_t i = 0; i < x.size(); ++i) d[i] = end[i] - x[i];
    if (finite(d)) all.push_back(d);
  }
  for (size_t i = 0; i < x.size(); ++i) d[i] = x[i] - step.start[i];
  if (finite(d)) all.push_back(d);
  return all;
}

}  // namespace

std::vector<std::string> energies_acting(const FailedStep& step, std::span<const double> gradient) {
  std::vector<std::string> names;
  if (step.scene.energies().empty()) return names;
  const Unbalanced loads = unbalanced(step, gradient);
  for (int32_t k = 0; k < static_cast<int32_t>(step.scene.energies().size()); ++k) {
    const ModelBatch& energy = step.energies.batches[step.model.energy_batch(EnergyId{k})];
    bool acts = false;
    for (int64_t e = 0; e < energy.batch.size() && !acts; ++e)
      acts = block_of_element(step, loads, energy.batch, e) != kNoBlock;
    if (acts) names.push_back(energy.owner);
  }
  return names;
}

std::optional<RoughEnergy> find_rough_energy(const FailedStep& step, std::span<const double> gradient) {
  std::optional<RoughEnergy> found;
  if (step.scene.energies().empty()) return found;
  const Unbalanced loads = unbalanced(step, gradient);
  if (!(loads.force > 0.0)) return found;
  for (const std::vector<Vec3>& d : directions(step)) {
    for (int32_t k = 0; k < static_cast<int32_t>(step.scene.energies().size()); ++k)
      add_rough(step, loads, step.energies.batches[step.model.energy_batch(EnergyId{k})], d, found);
    if (found) break;
  }
  return found;
}

}  // namespace stark
