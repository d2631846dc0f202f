// Readings of reports: each has a name of its own, and is what the struct holds.
#include <doctest/doctest.h>

#include <set>
#include <string>

#include <stark/sim/step/report_readings.h>

using namespace stark;

namespace {

template <typename S>
size_t count_names() {
  std::set<std::string> names;
  size_t count = 0;
  for_each_reading<S>([&](const auto& row) {
    names.insert(row.name);
    ++count;
  });
  CHECK(names.size() == count);
  return count;
}

}  // namespace

TEST_CASE("names of readings are distinct") {
  CHECK(count_names<StepReport>() > 20);
  CHECK(count_names<Diagnosis>() > 10);
  CHECK(count_names<StepProgress>() > 10);
}

TEST_CASE("the ledger is read completely") {
  EnergyLedger energy{.kinetic = 1.0, .elastic = 2.0, .gravity = 4.0, .contact = 8.0, .numerical = 16.0};
  CHECK(count_names<EnergyLedger>() == sizeof(EnergyLedger) / sizeof(double));
  double sum = 0.0;
  for_each_reading<EnergyLedger>([&](const auto& row) { sum += row.read(energy); });
  CHECK(sum == 31.0);
}

TEST_CASE("readings reach into parts") {
  StepReport report;
  report.solve.residual = 3.0;
  for_each_reading<StepReport>([&](const auto& row) {
    if constexpr (requires { row.read(report) == 3.0; })
      if (std::string(row.name) == "residual") CHECK(row.read(report) == 3.0);
  });
}
