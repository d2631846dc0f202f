#include <stark/mechanics/self_stress.h>

#include <algorithm>
#include <cmath>

#include <stark/geometry/topology.h>

namespace stark {

namespace {

/// Of the stiffness of joints: what holds the motions that they leave free.
constexpr double kHeld = 1e-8;
/// Of the stiffness of a joint: what rounding errors of the weights of points in elements have of it.
constexpr double kRounding = 1e-20;
/// Solutions with what the one before has left, which is a small part of what kHeld holds.
constexpr int kPasses = 2;
/// Independent rows that a constraint of two frames has at most.
constexpr size_t kMostRows = 6;
/// Largest motion of the differences that residuals are compared over [m, rad].
constexpr double kProbe = 1e-5;

bool is_any(const std::vector<bool>& flags) { return std::ranges::find(flags, true) != flags.end(); }

size_t diagonal_slot(const BlockMatrix& matrix, int32_t block) {
  return 9 * static_cast<size_t>(matrix.pattern.row_start[block]);
}

double stiffness_at(const BlockMatrix& matrix, int32_t block) {
  const double* diagonal = matrix.values.data() + diagonal_slot(matrix, block);
  return diagonal[0] + diagonal[4] + diagonal[8];
}

void add_stiffness(BlockMatrix& matrix, int32_t block, double stiffness) {
  double* diagonal = matrix.values.data() + diagonal_slot(matrix, block);
  for (const size_t k : {0, 4, 8}) diagonal[k] += stiffness;
}

}  // namespace

SelfStress::SelfStress(const KinematicMap& map, ConstraintSet& constraints, ThreadPool& pool, Known may_break,
                       Known is_driven)
    : map_(map),
      constraints_(constraints),
      pool_(pool),
      may_break_(std::move(may_break)),
      is_driven_(std::move(is_driven)) {
  members_ = members_of(map, constraints);
  is_loop_possible_ = is_any(in_loops(std::vector<bool>(members_.size(), true)));
}

std::vector<SelfStress::Member> SelfStress::members_of(const KinematicMap& map,
                                                       const ConstraintSet& constraints) {
  std::vector<Member> members;
  for (const ConstraintGroup& group : constraints.groups()) {
    if (group.joint->units().empty()) continue;
    for (int64_t e = 0; e < group.batch.size(); ++e) {
      Member member{group.joints[e], std::min(group.joint->units().size(), kMostRows), {}};
      for (const int32_t site : group.batch.stencil(e)) map.append_blocks(site, member.blocks);
      std::ranges::sort(member.blocks);
      const auto doubled = std::ranges::unique(member.blocks);
      member.blocks.erase(doubled.begin(), doubled.end());
      members.push_back(std::move(member));
    }
  }
  return members;
}

size_t SelfStress::row_count(const Member& member) const {
  return constraints_.groups()[constraints_.place(member.joint).group].joint->units().size();
}

size_t SelfStress::first_row(const Member& member) const {
  return static_cast<size_t>(constraints_.place(member.joint).residual);
}

// What is held by blocks that nothing else holds has forces of its own; without it the next one may, from the
// ends of chains to their roots. What is left are loops.
std::vector<bool> SelfStress::in_loops(const std::vector<bool>& acts) const {
  std::vector<int32_t> holders(map_.layout().block_count), last(holders.size());
  std::vector<bool> is_left(members_.size());
  const auto count = [&](size_t m, int32_t step) {
    is_left[m] = step > 0;
    for (const int32_t block : members_[m].blocks) {
      holders[block] += step;
      last[block] ^= static_cast<int32_t>(m);  // of one holder, its number
    }
  };
  std::vector<size_t> ends;
  const auto is_end = [&](size_t m) {
    size_t rows = 0;
    for (const int32_t block : members_[m].blocks) rows += holders[block] == 1 ? 3 : 0;
    return rows >= members_[m].rows;
  };
  for (size_t m = 0; m < members_.size(); ++m)
    if (acts[m] && !members_[m].blocks.empty()) count(m, 1);
  for (size_t m = 0; m < members_.size(); ++m)
    if (is_left[m] && is_end(m)) ends.push_back(m);
  while (!ends.empty()) {
    const size_t end = ends.back();
    ends.pop_back();
    if (!is_left[end]) continue;
    count(end, -1);
    for (const int32_t block : members_[end].blocks)
      if (holders[block] == 1 && is_end(static_cast<size_t>(last[block])))
        ends.push_back(static_cast<size_t>(last[block]));
  }
  return is_left;
}

std::vector<bool> SelfStress::joined_to(const std::vector<bool>& some, const std::vector<bool>& acts) const {
  std::vector<Index3> links;
  for (size_t m = 0; m < members_.size(); ++m)
    if (acts[m])
      for (const int32_t block : members_[m].blocks)
        links.push_back({members_[m].blocks.front(), block, block});
  const int32_t count = map_.layout().block_count;
  const std::vector<int32_t> component = find_connected_components(count, links);
  std::vector<bool> is_chosen(count), result(members_.size());
  for (size_t m = 0; m < members_.size(); ++m)
    if (acts[m] && some[m] && !members_[m].blocks.empty())
      is_chosen[component[members_[m].blocks.front()]] = true;
  for (size_t m = 0; m < members_.size(); ++m)
    result[m] = acts[m] && !members_[m].blocks.empty() && is_chosen[component[members_[m].blocks.front()]];
  return result;
}

std::vector<bool> SelfStress::joined_to_breakable(const std::vector<bool>& acts,
                                                  const std::vector<bool>& loops) const {
  std::vector<bool> breakable(members_.size());
  for (size_t m = 0; m < members_.size(); ++m) breakable[m] = loops[m] && may_break_(members_[m].joint);
  return is_any(breakable) ? joined_to(breakable, acts) : breakable;
}

std::vector<bool> SelfStress::members_of(const std::vector<bool>& rows) const {
  std::vector<bool> members(members_.size());
  for (size_t m = 0; m < members_.size(); ++m)
    for (size_t k = 0; k < row_count(members_[m]); ++k)
      if (rows[first_row(members_[m]) + k]) members[m] = true;
  return members;
}

std::vector<bool> SelfStress::torn(std::span<const double> misfits, const std::vector<bool>& acts) const {
  std::vector<bool> rows(acts.size());
  const std::vector<ConstraintSet::Violation> beyond = constraints_.nearly_beyond(misfits);
  if (beyond.empty()) return rows;
  const std::vector<bool> members = members_of(acts);
  std::vector<bool> tight(members_.size());
  for (size_t m = 0; m < members_.size(); ++m)
    tight[m] = std::ranges::find(beyond, members_[m].joint, &ConstraintSet::Violation::joint) != beyond.end();
  const std::vector<bool> breakable = joined_to_breakable(members, in_loops(members));
  const std::vector<bool> is_tight = joined_to(tight, members);
  for (size_t m = 0; m < members_.size(); ++m)
    for (size_t k = 0; breakable[m] && is_tight[m] && k < row_count(members_[m]); ++k)
      rows[first_row(members_[m]) + k] = acts[first_row(members_[m]) + k];
  return rows;
}

std::vector<double> SelfStress::held(const Configuration& configuration, std::span<const Vec3> x,
                                     std::span<const double> residuals) {
  const Acting acting = acting_with(residuals);
  if (acting.rows.empty()) return {};
  read(acting.loops, configuration, x);
  factorise();
  std::vector<double> result(residuals.begin(), residuals.end());
  const std::vector<bool> acts_here = system_->part(acting.rows);
  const std::optional<std::vector<double>> pushed = by_residuals(system_->part(result), acts_here);
  if (!pushed) return {};
  for (size_t r = 0; r < system_->row_count(); ++r)
    if (acts_here[r]) result[system_->row(r)] = (*pushed)[r] / system_->constraints().penalties()[r];
  return result;
}

// Penalties that grew in the step start anew in the next one, whose multipliers make up for what they have
// there.
SelfStress::End SelfStress::end(const Configuration& configuration, std::span<const Vec3> x) {
  const std::vector<double> residuals = constraints_.residuals(x);
  End end{constraints_.reactions(residuals), constraints_.next_multipliers(residuals), {}};
  const Acting acting = acting_with(residuals);
  if (acting.rows.empty()) return end;
  read(acting.loops, configuration, x);
  const std::vector<double> penalties = system_->part(constraints_.first_penalties());
  const std::vector<double> residuals_here = system_->part(residuals);
  const std::vector<double> all_forces = system_->part(end.forces);
  const std::vector<bool> acts_here = system_->part(acting.rows);
  std::vector<double> multipliers = all_forces;
  for (size_t r = 0; r < penalties.size(); ++r) multipliers[r] -= penalties[r] * residuals_here[r];
  system_->constraints().set_inputs({multipliers, penalties});
  factorise();
  const std::optional<std::vector<double>> forces = moving_part(all_forces, acts_here);
  const std::optional<std::vector<double>> pushed = by_residuals(residuals_here, acts_here);
  if (!forces || !pushed) return end;
  const std::vector<char> one_sided = constraints_.one_sided();
  end.misfits.assign(residuals.size(), 0.0);
  for (size_t r = 0; r < penalties.size(); ++r)
    if (acts_here[r]) end.misfits[system_->row(r)] = residuals_here[r] - (*pushed)[r] / penalties[r];
  const std::vector<bool> is_torn = torn(end.misfits, acting.rows);
  for (size_t r = 0; r < penalties.size(); ++r) {
    if (!acts_here[r]) continue;
    const size_t row = system_->row(r);
    const double stress = penalties[r] * end.misfits[row];
    end.forces[row] = (*forces)[r] + (is_torn[row] ? stress : 0.0);
    end.multipliers[row] = (*forces)[r] - stress;
    if (one_sided[row] == 0) continue;
    end.forces[row] = std::max(0.0, end.forces[row]);
    end.multipliers[row] = std::max(0.0, end.multipliers[row]);
  }
  return end;
}

SelfStress::Acting SelfStress::acting_with(std::span<const double> residuals) const {
  if (!is_loop_possible_) return {};
  const std::vector<double> forces = constraints_.reactions(residuals);
  const std::vector<char> one_sided = constraints_.one_sided();
  std::vector<bool> rows(forces.size());
  for (size_t r = 0; r < forces.size(); ++r)
    rows[r] = constraints_.penalties()[r] > 0.0 && (one_sided[r] == 0 || forces[r] > 0.0);
  const std::vector<bool> acts = members_of(rows);
  std::vector<bool> loops = in_loops(acts);
  const std::vector<bool> breakable = joined_to_breakable(acts, loops);
  std::vector<bool> driven(members_.size()), is_left = loops;
  if (is_any(breakable)) {
    for (size_t m = 0; m < members_.size(); ++m) driven[m] = is_driven_(members_[m].joint);
    driven = joined_to(driven, acts);
  }
  for (size_t m = 0; m < members_.size(); ++m) {
    if (!breakable[m] || !driven[m]) continue;
    is_left[m] = false;
    for (size_t k = 0; k < row_count(members_[m]); ++k) rows[first_row(members_[m]) + k] = false;
  }
  if (!is_any(is_left)) rows.clear();
  return {std::move(rows), std::move(loops)};
}

// Which limits act, and with them what is in loops, changes seldom.
void SelfStress::read(const std::vector<bool>& loops, const Configuration& configuration,
                      std::span<const Vec3> x) {
  if (!system_ || loops != loops_) make_system(loops);
  system_->read(constraints_, configuration, x);
}

void SelfStress::make_system(const std::vector<bool>& loops) {
  loops_ = loops;
  std::vector<bool> chosen(static_cast<size_t>(constraints_.joint_count()));
  for (size_t m = 0; m < members_.size(); ++m) chosen[members_[m].joint] = loops[m];
  system_ = std::make_unique<LoopSystem>(map_, constraints_, chosen);
  system_members_ = members_of(system_->map(), system_->constraints());
  assembler_ = std::make_unique<Assembler>(system_->map(), pool_);
  std::vector<PotentialBatch*> batches;
  for (ConstraintGroup& group : system_->constraints().groups()) batches.push_back(&group.batch);
  assembler_->set_static_batches(batches);
  LinearSettings settings;
  settings.solver = "cholesky";
  solver_ = make_linear_solver(settings, pool_);
}

std::optional<std::vector<double>> SelfStress::by_residuals(std::span<const double> residuals,
                                                            const std::vector<bool>& acts) {
  std::vector<double> forces(residuals.size());
  for (size_t r = 0; r < forces.size(); ++r)
    if (acts[r]) forces[r] = system_->constraints().penalties()[r] * residuals[r];
  return moving_part(std::move(forces), acts);
}

void SelfStress::factorise() {
  const size_t blocks = static_cast<size_t>(system_->map().layout().block_count);
  gradient_.assign(3 * blocks, 0.0);
  assembler_->assemble(system_->configuration(), system_->sites(), {.project = true, .pending = {}},
                       gradient_, hessian_);
  // What a constraint moves by nothing but rounding errors would move by any amount.
  std::vector<std::pair<int32_t, double>> still;
  for (const Member& member : system_members_) {
    double largest = 0.0;
    for (const int32_t block : member.blocks) largest = std::max(largest, stiffness_at(hessian_, block));
    for (const int32_t block : member.blocks)
      if (stiffness_at(hessian_, block) < kRounding * largest) still.emplace_back(block, largest);
  }
  for (size_t b = 0; b < blocks; ++b) {
    const double stiffness = stiffness_at(hessian_, static_cast<int32_t>(b));
    add_stiffness(hessian_, static_cast<int32_t>(b), stiffness > 0.0 ? kHeld * stiffness : 1.0);
  }
  for (const auto& [block, stiffness] : still) add_stiffness(hessian_, block, stiffness);
  solver_->begin_step();
  is_factorised_ = false;
}

std::optional<std::vector<double>> SelfStress::moving_part(std::vector<double> forces,
                                                           const std::vector<bool>& acts) {
  std::vector<double> sum(forces.size());
  for (int pass = 0; pass < kPasses; ++pass) {
    const std::vector<double> u = displacements(forces);
    if (u.empty()) return {};
    const std::vector<double> rate = rates(u);
    for (size_t r = 0; r < sum.size(); ++r) {
      if (!acts[r]) continue;
      const double force = system_->constraints().penalties()[r] * rate[r];
      sum[r] += force;
      forces[r] -= force;
    }
  }
  return sum;
}

std::vector<double> SelfStress::displacements(std::span<const double> forces) {
  // Rows of one side pull with positive forces alone, so what is negative there is taken off.
  ConstraintSet& constraints = system_->constraints();
  const std::vector<char> one_sided = constraints.one_sided();
  std::vector<double> positive(forces.begin(), forces.end()), negative(forces.size());
  for (size_t r = 0; r < forces.size(); ++r)
    if (one_sided[r] != 0 && forces[r] < 0.0) positive[r] = 0.0, negative[r] = -forces[r];
  std::vector<double> taken_off(gradient_.size()), result(gradient_.size());
  const ConstraintSet::Inputs inputs = constraints.inputs();
  constraints.set_forces(positive);
  assembler_->assemble_gradient(system_->configuration(), system_->sites(), gradient_);
  if (std::ranges::any_of(negative, [](double force) { return force > 0.0; })) {
    constraints.set_forces(negative);
    assembler_->assemble_gradient(system_->configuration(), system_->sites(), taken_off);
    for (size_t i = 0; i < gradient_.size(); ++i) gradient_[i] -= taken_off[i];
  }
  constraints.set_inputs(inputs);
  const LinearSystem system{.A = hessian_, .b = gradient_};
  const LinearSolveReport solved =
      is_factorised_ ? solver_->solve_again(system, result) : solver_->solve(system, result);
  is_factorised_ = solved.ok;
  const bool is_finite = std::ranges::all_of(result, [](double u) { return std::isfinite(u); });
  if (!solved.ok || !is_finite) result.clear();
  return result;
}

std::vector<double> SelfStress::rates(std::span<const double> displacements) const {
  double largest = 0.0;
  for (const double value : displacements) largest = std::max(largest, std::fabs(value));
  std::vector<double> rate(system_->row_count());
  if (largest == 0.0) return rate;
  const double scale = kProbe / largest;
  const KinematicMap& map = system_->map();
  Configuration moved;
  std::vector<Vec3> sites(system_->sites().size());
  for (const double sign : {1.0, -1.0}) {
    map.retract(system_->configuration(), displacements, sign * scale, KinematicMap::Way::Straight, moved);
    map.positions(moved, sites);
    for (int32_t i = 0; i < map.site_count(); ++i)
      if (map.is_prescribed(i)) sites[i] = system_->sites()[i];
    const std::vector<double> values = system_->constraints().residuals(sites);
    for (size_t r = 0; r < rate.size(); ++r) rate[r] += sign * values[r] / (2.0 * scale);
  }
  return rate;
}

}  // namespace stark
