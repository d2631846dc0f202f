// The journey of a time step (ARCHITECTURE.md): predict, freeze, minimise, accept or halve, commit, report.
#include <algorithm>
#include <chrono>
#include <cmath>
#include <limits>
#include <optional>

#include <stark/sim/model/internal_variables.h>
#include <stark/sim/step/attempt_failure.h>
#include <stark/sim/step/step_evidence.h>
#include <stark/sim/step/step_runner.h>
#include <stark/sim/step/time_marks.h>
#include <stark/sim/step/verdict.h>

namespace stark {

namespace {

/// Acceleration that rounding may leave in silence [m/s^2]: twice the default tolerance.
constexpr double kSilentRounding = 0.02;

/// Whatever has mass is slower [m/s].
constexpr double kSpeedOfLight = 299'792'458.0;

/// Share of the least distance by which a gap may be below it in silence: rounding, half of what a
/// certificate grants.
constexpr double kUnseen = 5e-7;

/// Attempts that fail before barriers are raised: a shorter step is the milder remedy.
constexpr int kAttemptsBeforeRaise = 2;

/// Attempts with the shortest step that failed for contacts too soft to stop what comes, and are repeated.
constexpr int kRepeatsOfShortest = 4;

/// Part of the kinetic energy that contact may store at most by giving way to impacts.
constexpr double kRelief = 0.01;

/// Delay with which contact follows the loads that last [s], and that of quasistatic steps, which have no
/// time.
constexpr double kLoadTime = 0.1, kQuasistaticLoad = 4.0;

LoadMemory load_of(const State& state) {
  return {state.contact_bodies, state.contact_factor, state.contact_trial, state.contact_trial_age};
}

void add_counters(SolveReport& total, const SolveReport& attempt) {
  SolveReport sum = attempt;
  sum.iterations += total.iterations;
  sum.linear_iterations += total.linear_iterations;
  sum.factorizations += total.factorizations;
  sum.backtracks += total.backtracks;
  sum.projected_iterations += total.projected_iterations;
  sum.lag_updates += total.lag_updates;
  total = sum;
}

/// Residual over its tolerance, motion over that of lengths, from which prescribed parts pull no joint apart.
constexpr double kFarApart = 2.0, kHardly = 0.1;

/// The largest of prescribed sites in a step to a target from sites at `start` [m].
double prescribed_motion(const KinematicMap& map, const Configuration& target, std::span<const Vec3> start) {
  std::vector<Vec3> end(start.size());
  map.positions(target, end);
  double motion = 0.0;
  for (int32_t i = 0; i < map.site_count(); ++i)
    if (map.is_prescribed(i)) motion = std::max(motion, norm(end[i] - start[i]));
  return motion;
}

/// The next number of one digit above twice a value.
double rounded_up(double value) {
  const double digit = std::pow(10.0, std::floor(std::log10(2.0 * value)));
  return std::ceil(2.0 * value / digit) * digit;
}

/// "; newton.acceleration_tolerance = 0.3 m/s^2 would fit" for those that are not met.
std::string fitting_tolerances(const NewtonSettings& newton, const SolveReport& solve, double h) {
  std::string text;
  const auto check = [&](const char* name, const char* unit, double tolerance, double reached) {
    if (tolerance > 0.0 && !(reached < tolerance))
      text += std::string(text.empty() ? "; " : ", ") + name + " = " + rough_text(rounded_up(reached), unit);
  };
  check("newton.acceleration_tolerance", "m/s^2", newton.acceleration_tolerance, solve.acceleration);
  check("newton.residual_tolerance", "N", newton.residual_tolerance, solve.residual);
  check("newton.step_tolerance", "m/s", newton.step_tolerance, solve.last_motion / h);
  return text.empty() ? text : text + " would fit";
}

bool is_below_least_distance(const Nearness& near) { return near.nearest < (1.0 - kUnseen) * near.least; }

}  // namespace

StepRunner::StepRunner(const StepContext& context, const StepParts& parts, Assembler& assembler,
                       LinearSolver& linear_solver)
    : StepPart(context),
      motion_(parts.motion),
      joints_(parts.joints),
      ledger_(parts.ledger),
      way_(parts.way),
      watch_(parts.watch),
      placing_(parts.placing),
      assembler_(assembler),
      linear_solver_(linear_solver),
      newton_(settings_.newton, linear_solver, timer_) {
  newton_.set_static(!has_inertia(settings_.time.integrator));
}

StepProgress StepRunner::progress() const {
  StepProgress progress;
  progress.step = state_.step_count + 1;
  progress.attempt = static_cast<int>(attempts_.size()) + 1;
  progress.solve = newton_.progress();
  progress.iterations = report_.solve.iterations + progress.solve.iterations;
  if (contact_) progress.contact_count = static_cast<int64_t>(contact_->contacts().size());
  return progress;
}

const StepReport& StepRunner::step(double max_time_step) {
  begin();
  const PlannedStep planned = plan_step(state_, max_time_step, motion_.longest_turning_step());
  std::optional<double> h = planned.length;
  while (h) {
    if (attempt(*h, report_.solve)) {
      accept(*h, planned.is_cut && *h == planned.length);
      break;
    }
    h = next_attempt(*h);
  }
  return report_;
}

void StepRunner::begin() {
  report_ = {};
  report_.step = state_.step_count + 1;
  timer_.reset();
  attempts_.clear();
  repeats_ = 0;
  goes_deep_ = false;
  energy_at_fault_.clear();
  load_ = load_of(state_);
  watch_.begin_step();
  linear_solver_.begin_step();
  set_deadline();
}

std::optional<double> StepRunner::next_attempt(double h) {
  const SolveStatus status = report_.solve.status;
  report_.message =
      status == SolveStatus::ConstraintViolated ? joints_.violation_text() : failure_of(status).text();
  if (status == SolveStatus::Interrupted) {
    finish_report(StepStatus::Interrupted);
    return {};
  }
  if (energy_at_fault_.empty() && is_stuck(status)) energy_at_fault_ = find_energy_at_fault(h);
  if (!energy_at_fault_.empty()) report_.message = energy_at_fault_;
  if (goes_deep_ = may_go_deep(status); goes_deep_) return h;
  ++report_.rejected_steps;
  const bool is_last = is_shortest(h);
  if (contact_ && is_stuck(status) && (is_last || report_.rejected_steps >= kAttemptsBeforeRaise)) {
    constexpr double kAny = std::numeric_limits<double>::infinity();
    const double kinetic = has_inertia(settings_.time.integrator) ? energies_before_.kinetic : kAny;
    LoadMemory raised =
        contact_->raised_load(potential_.site_positions(), step_start_, load_of(state_), kinetic);
    const bool is_raised = raised.bodies != load_.bodies || raised.factor != load_.factor;
    load_ = std::move(raised);
    const bool is_repeated = is_raised && is_last && status == SolveStatus::LineSearchFailed;
    if (is_repeated && repeats_++ < kRepeatsOfShortest) return h;
  }
  const bool is_hopeless = status == SolveStatus::TimeBudget || status == SolveStatus::RunAway ||
                           (status == SolveStatus::MaxIterations && is_same_if_shorter_);
  if (!is_last && !is_hopeless) return 0.5 * h;
  report_.time_step = h;
  fail();
  return {};
}

// A strong motor pushes with all it has until a body moves: on the way to a solution it may press it to the
// least distance, a wall that the energy does not know. Stiffer contact would throw off what nothing presses.
bool StepRunner::may_go_deep(SolveStatus status) const {
  return contact_ && !goes_deep_ && !model_.actuators().empty() && is_stuck(status) &&
         report_.rejected_steps < kAttemptsBeforeRaise;
}

void StepRunner::set_deadline() {
  using Clock = std::chrono::steady_clock;
  // Longer budgets than a clock can count are none.
  constexpr double kLongest = 1e8;  // [s]
  std::optional<Clock::time_point> deadline;
  if (settings_.newton.max_seconds < kLongest)
    deadline = Clock::now() + std::chrono::duration_cast<Clock::duration>(
                                  std::chrono::duration<double>(settings_.newton.max_seconds));
  newton_.set_deadline(deadline);
}

void StepRunner::accept(double h, bool is_cut) {
  add_caveats(h);
  commit(h);
  advance_time(state_, h, is_cut);
  ++state_.step_count;
  {
    const PhaseTimer::Scope scope(timer_, Phase::Commit);
    if (contact_) energies_before_.contact += contact_->relief_energy();
    report_.energy = ledger_.balance(energies_before_, coordinates_before_);
    report_.energy.placed = placing_.placed().energy;
    report_.placed = placing_.placed().bodies;
    placing_.forget();
    report_.contact_energy_at_start = energies_before_.contact;
    report_.bristle_energy_at_start = contact_ ? contact_->bristle_energy_at_start() : 0.0;
  }
  report_.time_step = h;
  const bool goes_on = motion_.reference().stencil.history > 0.0;
  report_.lasting_contact = motion_.reference().stencil.lasting;
  if (goes_on || !has_inertia(settings_.time.integrator)) report_.integrator = settings_.time.integrator;
  // A halved step grows back towards the one asked for, whose mark it must not miss; a step cut short by the
  // caller does not shrink the next.
  if (report_.rejected_steps > 0)
    state_.time_step = h;
  else if (!is_cut)
    state_.time_step = std::min(settings_.time.step, state_.time_step * settings_.time.growth);
  finish_report(report_.rejected_steps > 0 ? StepStatus::Retried : StepStatus::Accepted);
}

void StepRunner::add_caveats(double h) {
  const SolveReport& solve = report_.solve;
  const NewtonSettings& newton = settings_.newton;
  const bool is_rough = solve.is_at_rounding && newton.acceleration_tolerance > 0.0 &&
                        solve.acceleration > std::max(newton.acceleration_tolerance, kSilentRounding);
  if (solve.status == SolveStatus::RoundOff || is_rough)
    add_caveat(Caveat::RoundOff, "accepted at round-off, short of the tolerances: unbalanced force " +
                                     rough_text(solve.residual, "N") + ", acceleration " +
                                     rough_text(solve.acceleration, "m/s^2") +
                                     fitting_tolerances(settings_.newton, solve, h));
  if (solve.is_settled)
    add_caveat(
        Caveat::OldFriction,
        "accepted with friction or joints one refresh behind: after it, Newton's method did not converge");
  if (const std::string bodies = way_.meeting_text(); !bodies.empty())
    add_caveat(Caveat::PrescribedOverlap,
               bodies +
                   " go into or through each other: nothing stops what is scripted or fixed on both sides; "
                   "change their motion, or disable contact between them if that is meant");
  if (watch_.has_overlap())
    add_caveat(Caveat::ReleasedOverlap, watch_.overlap_text() + ": no contact there until they are apart");
}

void StepRunner::add_caveat(Caveat caveat, const std::string& text) {
  report_.caveats.push_back(caveat);
  report_.message += (report_.message.empty() ? "" : "; ") + text;
}

void StepRunner::report_nearness() {
  const Nearness near = contact_->nearness(potential_.known_positions());
  report_.min_distance = near.distance;
  if (!is_below_least_distance(near)) return;
  const auto name = [&](int32_t group) { return "'" + scene_.name(BodyId{group}) + "'"; };
  add_caveat(Caveat::BelowLeastDistance,
             name(near.group_a) + " and " + (near.group_a == near.group_b ? "itself" : name(near.group_b)) +
                 " are " + rough_text(near.nearest, "m") + " apart, below the least distance " +
                 rough_text(near.least, "m") +
                 " that contact.min_separation_factor asks for: they started nearer, or contact is too soft "
                 "for an impact; raise contact_stiffness, or lower time.step");
}

void StepRunner::report_friction() {
  report_.friction_residual = contact_->friction_residual();
  // With a single update friction lags by choice; what changes by less than the residual is within that.
  const int updates = settings_.contact.friction_updates;
  const std::optional<LimitChange> left = contact_->unsettled_friction();
  if (!left || updates == 1 || report_.solve.is_settled || left->largest_change <= report_.solve.residual)
    return;
  add_caveat(Caveat::OldFriction, "limits of friction still changed by " +
                                      rough_text(left->largest_change, "N") + ", the largest there being " +
                                      rough_text(left->largest_limit, "N") +
                                      ", when contact.friction_updates = " + std::to_string(updates) +
                                      " were over; raise it, or lower time.step");
}

void StepRunner::fail() {
  report_.diagnosis = diagnose();
  // That iterations ran out, or that something is not finite, is what this verdict says itself, and what is
  // pressed by its own weight or speed is no obstacle.
  const bool is_said =
      report_.diagnosis.cause == FailureCause::IterationBudget ||
      report_.diagnosis.cause == FailureCause::NotFinite ||
      (report_.diagnosis.cause == FailureCause::CrushingLoad && report_.solve.status == SolveStatus::Blocked);
  const std::string cause = is_said ? "" : failure_of(report_.solve.status).cause;
  report_.message =
      (cause.empty() ? "" : cause + ": ") + report_.diagnosis.finding + "; " + report_.diagnosis.remedy;
  if (is_shortest(report_.time_step))
    report_.message +=
        "; the time step was halved down to time.min_step = " + quantity_text(settings_.time.min_step, "s") +
        " without success";
  finish_report(StepStatus::Failed);
}

void StepRunner::predict(double h, const Configuration& start, bool hits_stop) {
  const PhaseTimer::Scope scope(timer_, Phase::Predict);
  potential_.begin(start, motion_.target_configuration(h));
  step_start_.assign(potential_.site_positions().begin(), potential_.site_positions().end());
  motion_.begin(h, hits_stop);
  set_internal(energies_, state_.internal_variable);
  motion_.begin_flow(h);
  // Joints are measured against the inertia of the full time step: one cut short would stiffen them under
  // what already rests on them and throw it off. Quasistatic steps have no other measure of rigid bodies.
  const double full = motion_.reference().stencil.scale * settings_.time.step / h;
  if (energies_.constraints.joint_count() > 0)
    motion_.predict(h, full, full);
  else
    motion_.predict(h);
  energies_before_ = ledger_.begin(step_start_);
  coordinates_before_ = state_.joint_coordinate;
  joints_.begin_actuators(h);
}

bool StepRunner::attempt(double h, SolveReport& total) {
  const Configuration start = motion_.start_configuration();
  const bool has_joints = energies_.constraints.joint_count() > 0;
  predict(h, start, false);
  if (has_joints && joints_.hits_stop(h)) predict(h, start, true);
  if (has_joints) {
    joints_.begin(natural_stiffness(start), h);
    const PhaseTimer::Scope scope(timer_, Phase::Predict);
    motion_.predict(h);
  }
  if (contact_) {
    // Contact stiffened with a body in it throws the body back faster than it came. Where nothing drives the
    // bodies, an impact may go as deep as its energy brings it, unless an attempt has shown that this leads
    // nowhere.
    const bool is_driven = potential_.has_pending_motion() || !model_.actuators().empty();
    contact_->set_bound(!goes_deep_ && (report_.rejected_steps > 0 || is_driven));
    contact_->begin_step(potential_.known_positions(),
                         {.positions = motion_.reference().friction_sites,
                          .duration = motion_.reference().friction_duration,
                          .step = h,
                          .weight = motion_.reference().stencil.contact_weight,
                          .motion = motion_.restitution_motion(h),
                          .surface_velocity = state_.surface_velocity,
                          .surface_spin = state_.surface_spin},
                         {{state_.friction_pair, state_.friction_deflection, state_.friction_force},
                          load_,
                          watch_.close(),
                          motion_.restitution_memory()});
    energies_before_.contact = contact_->energy();
    if (!is_driven && has_inertia(settings_.time.integrator))
      contact_->allow_relief(kRelief * energies_before_.kinetic);
  }
  // Friction is not worth refreshing in a motion that will be thrown away.
  // Why the shortest step fails is seen best where Newton's method comes to its end.
  newton_.set_way_check([&] { return !way_.leads_through_something(start); }, !is_shortest(h));
  std::vector<double> guess;
  if (report_.rejected_steps == 0 && has_inertia(settings_.time.integrator))
    guess = motion_.free_increments(h);
  SolveReport solved = minimize(h, guess, total);
  newton_.set_way_check({});
  if (is_success(solved.status) && way_.leads_through_something(start)) solved.status = SolveStatus::Detour;
  if (is_success(solved.status) && goes_deep_ &&
      is_below_least_distance(contact_->nearness(potential_.known_positions())))
    solved.status = SolveStatus::LineSearchFailed;
  if (is_success(solved.status)) {
    // Energies may be finite where flow is not, as of metal that is drawn out a hundredfold.
    remembered_ = updated_internal(energies_, potential_.site_positions());
    const bool is_finite = std::ranges::all_of(remembered_, [](double v) { return std::isfinite(v); });
    if (!is_finite) solved.status = SolveStatus::NotFinite;
  }
  if (is_success(solved.status) && is_faster_than_light(h)) solved.status = SolveStatus::RunAway;
  attempts_.push_back({h, solved.status, solved.iterations});
  add_counters(total, solved);
  return is_success(solved.status);
}

SolveReport StepRunner::minimize(double h, std::span<const double> guess, SolveReport& total) {
  is_same_if_shorter_ = !has_inertia(settings_.time.integrator) && !potential_.has_pending_motion();
  SolveReport solved = newton_.minimize(potential_, h, guess);
  for (double shorter = h; is_same_if_shorter_ && !is_shortest(shorter); shorter *= 0.5) {
    if (solved.status != SolveStatus::MaxIterations) break;
    attempts_.push_back({h, solved.status, solved.iterations});
    add_counters(total, solved);
    solved = newton_.minimize(potential_, h);
  }
  return solved;
}

// Forces of a user's loop that swing up would go on to infinity otherwise, step by accepted step.
bool StepRunner::is_faster_than_light(double h) const {
  const KinematicMap& map = model_.map();
  const std::span<const Vec3> x = potential_.site_positions();
  const double limit = h * kSpeedOfLight;
  for (int32_t i = 0; i < map.site_count(); ++i)
    if (!map.is_prescribed(i) && squared_norm(x[i] - step_start_[i]) > limit * limit) return true;
  return false;
}

FailedStep StepRunner::last_attempt(const Configuration& target) {
  return {.scene = scene_,
          .settings = settings_,
          .model = model_,
          .energies = energies_,
          .potential = potential_,
          .contact = contact_,
          .start = step_start_,
          .target = target,
          .direction = newton_.direction(),
          .is_first_step = state_.step_count == 0,
          .is_detour = report_.solve.status == SolveStatus::Detour};
}

std::string StepRunner::find_energy_at_fault(double h) {
  if (scene_.energies().empty()) return {};
  StepEvidence evidence = collect_energy_evidence(last_attempt(motion_.target_configuration(h)));
  evidence.solve = report_.solve;
  const Verdict verdict = judge_users_energies(evidence);
  if (verdict.cause == FailureCause::None) return {};
  return failure_of(report_.solve.status).cause + ": " + verdict.finding + "; " + verdict.remedy;
}

Diagnosis StepRunner::diagnose() {
  const double h = attempts_.back().time_step;
  StepEvidence evidence = collect_evidence(last_attempt(motion_.target_configuration(h)));
  evidence.solve = report_.solve;
  evidence.time_step = h;
  evidence.attempts = attempts_;
  for (const auto* gaps : {&evidence.start_gaps, &evidence.gaps})
    if (!gaps->empty()) evidence.released_by = watch_.releaser_of(gaps->front().a.body, gaps->front().b.body);
  const std::string start = joints_.violation_text(step_start_, [](int32_t) { return true; });
  if (report_.solve.status == SolveStatus::ConstraintViolated) {
    evidence.joint_violation = joints_.violation_text();
    const double apart = energies_.constraints.worst(potential_.site_positions()).ratio;
    const double motion = prescribed_motion(model_.map(), motion_.target_configuration(h), step_start_);
    // What hangs on one prescribed part alone follows it.
    const bool is_pulled = evidence.is_between && motion > 0.0 &&
                           (apart < kFarApart || motion > kHardly * settings_.joints.length_tolerance);
    const std::string misfit = is_pulled ? "" : joints_.misfit_text();
    evidence.joints_held = !is_pulled && misfit.empty() && start.empty();
    if (!misfit.empty()) evidence.joint_violation = misfit;
  }
  Diagnosis diagnosis = judge(std::move(evidence), settings_);
  if (!start.empty()) {
    diagnosis.finding += "; when the step began, " + start;
    diagnosis.remedy = "bring both sides together before they are held; " + diagnosis.remedy;
  }
  return diagnosis;
}

std::vector<Mat3> StepRunner::natural_stiffness(const Configuration& start) {
  joints_.release();
  assembler_.set_dynamic_batches({});
  scratch_gradient_.assign(3 * static_cast<size_t>(model_.map().layout().block_count), 0.0);
  const PhaseTimer::Scope scope(timer_, Phase::Stiffness);
  assembler_.assemble(start, potential_.site_positions(),
                      {.project = false, .pending = {}, .pairs = ScatterPairs::Diagonal}, scratch_gradient_,
                      diagonal_hessian_);
  std::vector<Mat3> diagonal(model_.map().layout().block_count);
  for (int32_t b = 0; b < static_cast<int32_t>(diagonal.size()); ++b)
    std::copy_n(diagonal_hessian_.values.data() + 9 * diagonal_hessian_.pattern.row_start[b], 9,
                diagonal[b].m.data());
  return diagonal;
}

void StepRunner::commit(double h) {
  state_.internal_variable = std::move(remembered_);
  motion_.commit(h);
  if (contact_) commit_contact(h);
  if (const std::string text = joints_.commit(); !text.empty()) add_caveat(Caveat::MisfitLoop, text);
}

void StepRunner::commit_contact(double h) {
  const PhaseTimer::Scope scope(timer_, Phase::Commit);
  const bool has_time = has_inertia(settings_.time.integrator);
  const double duration = has_time ? h / kLoadTime : kQuasistaticLoad;
  RestitutionSet::End motion;
  if (contact_->has_restitution() && has_time) motion = motion_.restitution_end(h);
  ContactMemory memory = contact_->end_step(potential_.known_positions(), duration, motion);
  state_.friction_pair = std::move(memory.friction.pair);
  state_.friction_deflection = std::move(memory.friction.deflection);
  state_.friction_force = std::move(memory.friction.force);
  state_.contact_trial = memory.load.trials();
  state_.contact_trial_age = memory.load.trial_ages();
  state_.contact_bodies = std::move(memory.load.bodies);
  state_.contact_factor = std::move(memory.load.factor);
  state_.contact_close_bodies = std::move(memory.close.bodies);
  state_.contact_close_distance = std::move(memory.close.distance);
  motion_.remember_impacts(std::move(memory.restitution));
  state_.contact_regained = watch_.regained();
}

void StepRunner::finish_report(StepStatus status) {
  report_.status = status;
  report_.time = state_.time;
  if (report_.failed()) step_start_.clear();  // sensors have nothing to tell of it
  if (!report_.failed()) {
    report_.min_distance = std::numeric_limits<double>::infinity();
    if (contact_) report_nearness(), report_friction();
    report_.contact_count = contact_ ? static_cast<int64_t>(contact_->contacts().size()) : 0;
    report_.momentum = ledger_.momentum();
  }
  for (size_t k = 0; k < report_.phases.size(); ++k)
    report_.phases[k] = timer_.seconds(static_cast<Phase>(k));
}

}  // namespace stark
