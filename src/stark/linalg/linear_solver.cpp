// What all linear solvers share, and their registry. See linear_solver.h.
#include <stark/linalg/linear_solver.h>

#include <algorithm>
#include <mutex>

#include <stark/base/error.h>
#include <stark/linalg/automatic_solver.h>
#include <stark/linalg/direct_solver.h>
#include <stark/linalg/pcg_solver.h>

namespace stark {

namespace {

template <typename Solver>
std::unique_ptr<LinearSolver> make(const LinearSettings& settings, ThreadPool& pool) {
  return std::make_unique<Solver>(settings, pool);
}

struct Row {
  std::string name;
  MakeLinearSolver make;
};

struct Registry {
  std::mutex mutex;
  std::vector<Row> rows{{"automatic", make<AutomaticSolver>},
                        {"cholesky", make<CholeskySolver>},
                        {"cholesky_float", make<CholeskyFloatSolver>},
                        {"pcg", make<PcgSolver>}};

  const Row* find(std::string_view name) const {
    const auto row = std::ranges::find(rows, name, &Row::name);
    return row == rows.end() ? nullptr : &*row;
  }
};

Registry& registry() {
  static Registry all;
  return all;
}

}  // namespace

const FieldTable& LinearSettings::fields() {
  static const FieldTable table("linear", TableKind::Settings,
                                {
#define STARK_SETTING(type, name, value, unit, rule, meaning) \
  field(&LinearSettings::name, #name, unit, rule, meaning),
#include <stark/linalg/linear_settings.inc>
#undef STARK_SETTING
                                });
  return table;
}

LinearSolveReport LinearSolver::solve(const LinearSystem& system, std::span<double> x) {
  const BlockPattern& pattern = system.A.pattern;
  const size_t size = 3 * static_cast<size_t>(pattern.block_count);
  STARK_CHECK(system.b.size() == size && x.size() == size &&
              system.A.values.size() == 9 * pattern.column.size());
  LinearSolveReport report;
  if (size == 0)
    report.ok = true;
  else
    report = solve_system(system, x);
  has_solved_ = report.ok;
  return report;
}

LinearSolveReport LinearSolver::solve_again(const LinearSystem& system, std::span<double> x) {
  LinearSolveReport report;
  if (system.b.empty())
    report.ok = true;
  else if (has_solved_)
    report = solve_kept(system, x);
  return report;
}

void register_linear_solver(std::string name, MakeLinearSolver make) {
  Registry& all = registry();
  const std::lock_guard lock(all.mutex);
  if (name.empty() || !make)
    throw InvalidArgument("register_linear_solver: needs a name and a function that makes the solver");
  if (all.find(name))
    throw InvalidArgument("register_linear_solver: '" + name +
                          "' is the name of another linear solver; choose another name");
  all.rows.push_back({std::move(name), std::move(make)});
}

std::vector<std::string> linear_solver_names() {
  Registry& all = registry();
  const std::lock_guard lock(all.mutex);
  std::vector<std::string> names;
  for (const Row& row : all.rows) names.push_back(row.name);
  return names;
}

std::unique_ptr<LinearSolver> make_linear_solver(const LinearSettings& settings, ThreadPool& pool) {
  LinearSettings::fields().validate(&settings);
  MakeLinearSolver make;
  {
    Registry& all = registry();
    const std::lock_guard lock(all.mutex);
    make = all.find(settings.solver)->make;
  }
  return make(settings, pool);
}

}  // namespace stark
