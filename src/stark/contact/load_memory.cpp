#include <stark/contact/load_memory.h>

#include <algorithm>
#include <cmath>
#include <utility>

namespace stark {

namespace {

/// A factor stays while the load asks for no less than this part of it and no more than its inverse: a body
/// at rest is to rest. Gaps follow it one to one.
constexpr double kEnough = 0.99;

/// Where a factor starts, and where it ends when the load is gone. It acts from 1 on: what is over by then
/// was an impact, which must not meet a stiffer law on its way out.
constexpr double kStart = 1.0 / 16.0;

/// Growth of a factor from which a trial shows something, and what it may grow by until it has: logarithms.
constexpr double kShows = 0.05, kFree = 0.1;

/// Part of what a constant load would make the pressing fall by, from which it is one.
constexpr double kOpens = 0.85;

/// Logarithm of the rise of the pressing which is not that of the factor: something presses harder.
constexpr double kPressed = 0.1;

/// Growth of a trial over that of the last one that opened the gap.
constexpr double kNextGrowth = 2.0;

/// Age at which a trial that has shown nothing begins anew, and the factor to the next such age: the load may
/// have grown by chance as the factor did.
constexpr double kFirstRetry = 2.0, kRetries = 4.0;

/// Follows the logarithm of what the load asks for with a delay, up and down alike: an oscillating load would
/// pump what grows fast and shrinks slowly.
double next_factor(double factor, double wanted, double duration) {
  const double ratio = std::max(wanted, kStart) / factor;
  if (kEnough < ratio && ratio < 1.0 / kEnough) return factor > kStart / kEnough ? factor : 0.0;
  const double next = factor * std::pow(ratio, 1.0 - std::exp(-duration));
  return next > kStart / kEnough ? next : 0.0;
}

/// Retries that are due up to an age.
double retries(double age) {
  return age < kFirstRetry ? 0.0 : 1.0 + std::floor(std::log(age / kFirstRetry) / std::log(kRetries));
}

/// What is known of a pair whose load asks for more than its factor, after another step.
LoadTrial continued(LoadTrial trial, double factor, double pressing, double duration) {
  const double age = trial.age + duration;
  const double growth = std::log(factor / trial.factor), fall = std::log(trial.pressing / pressing);
  if (growth >= kShows && fall >= kOpens * growth)
    return {factor, pressing, factor * std::exp(std::max(kFree, kNextGrowth * growth)), 0.0};
  if (fall < -kPressed) {
    const double rise = pressing / trial.pressing;
    return {trial.factor * rise, pressing, trial.most * rise, age};
  }
  if (retries(age) > retries(trial.age)) return {factor, pressing, factor * std::exp(kFree), age};
  trial.age = age;
  return trial;
}

}  // namespace

LoadMemory::LoadMemory(std::vector<int64_t> pairs, std::vector<double> factors, std::span<const Vec3> trials,
                       std::span<const double> ages)
    : bodies(std::move(pairs)), factor(std::move(factors)), trial(bodies.size()) {
  for (size_t k = 0; k < std::min(trials.size(), ages.size()); ++k)
    trial[k] = {trials[k].x, trials[k].y, trials[k].z, ages[k]};
}

void LoadMemory::add(int64_t code, double value, const LoadTrial& its_trial) {
  if (!(value > 0.0)) return;
  bodies.push_back(code);
  factor.push_back(value);
  trial.push_back(its_trial);
}

void LoadMemory::follow(const LoadMemory& before, int64_t code, double wanted, double duration) {
  const double known = before.pending(code), acting = before.find(code);
  const double next = next_factor(known, wanted, duration);
  if (!(next > acting)) return add(code, next);
  const double pressing = wanted / acting;
  const LoadTrial last = before.trial_of(code);
  const LoadTrial now = last.factor > 0.0
                            ? continued(last, acting, pressing, duration)
                            : LoadTrial{acting, pressing, std::max(next, acting * std::exp(kFree)), 0.0};
  add(code, std::min(next, std::max(acting, now.most)), now);
}

std::optional<size_t> LoadMemory::place(int64_t code) const {
  const auto found = std::ranges::lower_bound(bodies, code);
  if (found == bodies.end() || *found != code) return {};
  return found - bodies.begin();
}

double LoadMemory::pending(int64_t code) const {
  const auto k = place(code);
  return k ? factor[*k] : kStart;
}

double LoadMemory::find(int64_t code) const { return std::max(1.0, pending(code)); }

LoadTrial LoadMemory::trial_of(int64_t code) const {
  const auto k = place(code);
  return k ? trial[*k] : LoadTrial{};
}

bool LoadMemory::has_trials() const {
  return std::ranges::any_of(trial, [](const LoadTrial& t) { return t.factor > 0.0; });
}

std::vector<Vec3> LoadMemory::trials() const {
  std::vector<Vec3> all;
  if (!has_trials()) return all;
  for (const LoadTrial& t : trial) all.push_back({t.factor, t.pressing, t.most});
  return all;
}

std::vector<double> LoadMemory::trial_ages() const {
  std::vector<double> all;
  if (!has_trials()) return all;
  for (const LoadTrial& t : trial) all.push_back(t.age);
  return all;
}

}  // namespace stark
