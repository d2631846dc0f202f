// Stiffness of contact under loads that last: it follows a load until the gap is a tenth of the contact
// distance, and stays where the gap is not the load's to open [theory eq. 18a, 18b].
#include <doctest/doctest.h>

#include <stark/contact/load_memory.h>

#include <cmath>

using namespace stark;
using doctest::Approx;

namespace {

constexpr int64_t kPair = 7;
constexpr double kStep = 0.1;  // of 10 ms, over the delay

/// Steps of a pair whose load asks for wanted(factor).
template <typename Wanted>
LoadMemory after(int steps, double step, Wanted&& wanted, LoadMemory memory = {}) {
  for (int k = 0; k < steps; ++k) {
    LoadMemory next;
    next.follow(memory, kPair, wanted(memory.find(kPair), k), step);
    memory = next;
  }
  return memory;
}

/// Contact that is pressed to a gap where it asks for so many times its factor.
auto held(double times) {
  return [=](double factor, int) { return times * factor; };
}

/// A load that asks for this factor.
auto load(double wanted) {
  return [=](double, int) { return wanted; };
}

}  // namespace

TEST_CASE("a load that lasts gets the factor that it asks for, whatever the step") {
  for (const double step : {0.01, 0.1, 0.2, 4.0})
    CHECK(after(static_cast<int>(std::ceil(20.0 / step)), step, load(50.0)).find(kPair) ==
          Approx(50.0).epsilon(0.02));
}

TEST_CASE("so does one that grows, slowly or fast") {
  for (const double rate : {0.5, 3.0, 10.0}) {
    const auto grows = [&](double, int k) { return std::min(50.0, std::exp(0.01 * rate * k)); };
    CHECK(after(2500, kStep, grows).find(kPair) == Approx(50.0).epsilon(0.02));
  }
}

TEST_CASE("a gap that stiffer contact does not open leaves the factor as it is") {
  CHECK(after(150, kStep, held(3.0)).find(kPair) < 2.0);   // 1.5 s, e-fold in 0.09 s without trials
  CHECK(after(6000, kStep, held(3.0)).find(kPair) < 2.5);  // a minute
  CHECK(after(6000, kStep, held(300.0)).find(kPair) < 3.5);
  CHECK(after(6000, kStep, held(0.9)).find(kPair) == 1.0);  // above a tenth of the contact distance
}

TEST_CASE("a load after jaws, and jaws after a load") {
  const LoadMemory jaws = after(3000, kStep, held(3.0));
  CHECK(after(3000, kStep, load(50.0), jaws).find(kPair) == Approx(50.0).epsilon(0.02));
  const LoadMemory loaded = after(3000, kStep, load(50.0));
  CHECK(after(3000, kStep, held(1.5), loaded).find(kPair) < 2.0 * 50.0);
}

TEST_CASE("a gap that answers late is waited for") {
  double shown = 1.0;  // factor that the gap has followed
  const auto late = [&](double factor, int) {
    shown += 0.05 * (factor - shown);  // 20 steps later
    return 20.0 * factor / shown;
  };
  CHECK(after(4000, 0.01, late).find(kPair) == Approx(20.0).epsilon(0.02));
}

TEST_CASE("a load that is over is forgotten, with its trial") {
  const LoadMemory loaded = after(10, kStep, load(50.0));
  CHECK(loaded.find(kPair) > 1.0);
  CHECK(loaded.has_trials());
  const LoadMemory none = after(200, kStep, load(0.0), loaded);
  CHECK(none.bodies.empty());
  CHECK_FALSE(none.has_trials());
}

TEST_CASE("trials survive in the arrays of a state; older states have none") {
  const LoadMemory memory = after(10, kStep, load(50.0));
  const LoadMemory read(memory.bodies, memory.factor, memory.trials(), memory.trial_ages());
  CHECK(read.trial == memory.trial);
  const LoadMemory older(memory.bodies, memory.factor, {}, {});
  CHECK(older.find(kPair) == memory.find(kPair));
  CHECK_FALSE(older.has_trials());
  CHECK(older.trials().empty());
}
