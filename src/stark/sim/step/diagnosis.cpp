#include <stark/sim/step/diagnosis.h>

#include <algorithm>
#include <cmath>
#include <iterator>
#include <limits>
#include <utility>

#include <stark/sim/step/verdict.h>

namespace stark {

namespace {

/// Angle, or motion over the size of the scene, in the shortest step beyond which no step follows an
/// actuator.
constexpr double kOverwhelming = 0.5;
/// Part of the motion of a step, and of the acceleration that rounding leaves, from which an actuator makes
/// it.
constexpr double kDriven = 0.5, kRounded = 0.1;
/// Stretch of a body between two of its pins that nobody means.
constexpr double kPinStretch = 1.5;
/// Distance over contact distance below which bodies that start like that overlap in thickness.
constexpr double kOverlap = 0.1;
/// Distance over contact distance below which a load is no ordinary one: contact that it lasts on carries the
/// largest pressure at a tenth (theory, eq. 18a).
constexpr double kCrushed = 0.01;
/// Motion within the shortest step over the contact distance from which shorter steps may resolve an impact.
constexpr double kCrossed = 0.1;
/// Motion in a quasistatic step over the size of the scene from which nothing holds the bodies.
constexpr double kRunaway = 10.0;
/// Ratio of stiffnesses at which the softest is rounding of the stiffest.
constexpr double kContrast = 1e14, kContrastOfSolve = 1e11;
/// Multiple of the estimated rounding up to which a residual counts as rounding.
constexpr double kRoundingRange = 100.0;
/// Speed of a Newton step over newton.step_tolerance from which on it changes nothing.
constexpr double kStandstill = 0.01;
/// Largest coordinate over the size of the scene from which the place of the scene makes the rounding.
constexpr double kFar = 1e3;
constexpr size_t kNamedVertices = 4;

constexpr const char* kLeaveRoom =
    "end the prescribed motion before the obstacle, leave room for what is in between and for the contact "
    "distances, move the obstacle, or drive the body by an actuator with a force that has a cap";

std::string percent(double fraction) { return to_text(std::round(1e4 * fraction) / 100.0) + " %"; }

std::string force_text(const StepEvidence& e) {
  if (e.forces.empty()) return "";
  const UnbalancedForce& worst = e.forces.front();
  return "the largest unbalanced force is " + rough_text(worst.force, "N") + " (" +
         rough_text(worst.acceleration, "m/s^2") + ") on " + place_text(worst.at) + " near " +
         point_text(worst.position);
}

std::string pair_text(const BlockingPair& pair) {
  return place_text(pair.a) + " and " + place_text(pair.b) + " allow " + percent(pair.fraction) +
         " of the last Newton step before they touch";
}

std::string gap_text(const NarrowGap& gap) {
  return place_text(gap.a) + " is " + rough_text(gap.distance, "m") + " from " + place_text(gap.b) +
         ", within their contact distance of " + rough_text(gap.contact_distance, "m");
}

const StrainedElement* find_inverted(const StepEvidence& e, bool prescribed_only) {
  for (const StrainedElement& element : e.elements)
    if (!(element.size > 0.0) && (element.is_prescribed || !prescribed_only)) return &element;
  return nullptr;
}

Verdict judge_pins(const StepEvidence& e) {
  if (const StrainedElement* element = find_inverted(e, true))
    return {FailureCause::OverconstrainedPins,
            "prescribed vertices contradict each other: " + element_text(*element) +
                ", and all its vertices are pinned",
            "check the targets of these pins, or pin fewer vertices",
            {element->at.body}};
  if (e.pins && e.pins->stretch() > kPinStretch)
    return {FailureCause::OverconstrainedPins,
            "prescribed vertices pull " + place_text(e.pins->pins) + " to a distance of " +
                rough_text(e.pins->distance, "m") + ", " + rough_text(e.pins->stretch(), "1") +
                " times the length of what is between them, " + rough_text(e.pins->length, "m"),
            "check the targets of these pins, move them in smaller steps, or pin fewer vertices",
            {e.pins->pins.body}};
  return {};
}

bool is_stuck(SolveStatus status) {
  return status == SolveStatus::MaxIterations || status == SolveStatus::LineSearchFailed ||
         status == SolveStatus::Blocked;
}

/// Gaps of bodies that are pressed onto each other, where Newton's method came to no end: in the last
/// attempt, or at the start of the step if it was one before that.
std::vector<NarrowGap> crushed_gaps(const StepEvidence& e) {
  const SolveStatus last = e.solve.status;
  if (!is_stuck(last) && last != SolveStatus::ConstraintViolated && last != SolveStatus::Detour) return {};
  std::vector<NarrowGap> gaps;
  const auto add = [&](const std::vector<NarrowGap>& all) {
    std::ranges::copy_if(all, std::back_inserter(gaps),
                         [](const NarrowGap& g) { return g.ratio() < kCrushed; });
  };
  add(e.gaps);
  if (gaps.empty() && std::ranges::any_of(e.attempts, is_stuck, &Attempt::status)) add(e.start_gaps);
  return gaps;
}

std::vector<std::string> bodies_of(const std::vector<NarrowGap>& gaps) {
  std::vector<std::string> bodies;
  for (const NarrowGap& gap : gaps) bodies.insert(bodies.end(), {gap.a.body, gap.b.body});
  return bodies;
}

Verdict judge_load(const StepEvidence& e, const Settings& settings) {
  const std::vector<NarrowGap> gaps = crushed_gaps(e);
  if (gaps.empty()) return {};
  std::string finding =
      "forces press bodies together harder than contact can carry: " + gap_text(gaps.front()) + "; " +
      force_text(e);
  if (!e.released_by.empty()) finding += "; " + e.released_by + " was released, so they touch";
  std::string remedy =
      "lower the forces, caps of actuators and speeds that press these bodies together, or give them a "
      "higher contact_stiffness";
  const double speed = e.motion / e.time_step, least = settings.time.min_step;
  if (speed * least > kCrossed * gaps.front().contact_distance)
    remedy += ", or lower time.min_step = " + quantity_text(least, "s") + ", in which " + e.fastest.body +
              " moves by " + rough_text(speed * least, "m") + " at " + rough_text(speed, "m/s");
  return {FailureCause::CrushingLoad, std::move(finding), std::move(remedy), bodies_of(gaps)};
}

/// What prescribed parts press on.
Verdict blocked(const StepEvidence& e, const std::vector<NarrowGap>& crushed) {
  if (Verdict pins = judge_pins(e); pins.cause != FailureCause::None && find_inverted(e, true)) return pins;
  if (!e.blocking && e.gaps.empty() && crushed.empty()) return judge_pins(e);
  std::vector<std::string> bodies = e.pushing;
  std::string what = listed(e.pushing) + " cannot get where prescribed: ";
  if (e.blocking) {
    what += pair_text(*e.blocking);
    bodies.insert(bodies.end(), {e.blocking->a.body, e.blocking->b.body});
  } else {
    const NarrowGap& gap = e.gaps.empty() ? crushed.front() : e.gaps.front();
    what += gap_text(gap);
    bodies.insert(bodies.end(), {gap.a.body, gap.b.body});
  }
  for (const std::string& body : bodies_of(crushed)) bodies.push_back(body);
  return {FailureCause::BlockedMotion, what, kLeaveRoom, bodies};
}

/// What prescribed parts have pressed until it has no volume left.
Verdict judge_flattened(const StepEvidence& e) {
  if (!is_stuck(e.solve.status) || !e.is_between || e.pushing.empty()) return {};
  const auto flat =
      std::ranges::find_if(e.elements, [](const StrainedElement& element) { return element.size < kFlat; });
  if (flat == e.elements.end()) return {};
  std::vector<std::string> bodies = e.pushing;
  bodies.push_back(flat->at.body);
  return {FailureCause::BlockedMotion,
          listed(e.pushing) + " cannot get where prescribed: " + element_text(*flat), kLeaveRoom, bodies};
}

Verdict judge_prescribed(const StepEvidence& e, const Settings& settings) {
  // Energies without a value stop anything, prescribed or not.
  if (e.solve.status == SolveStatus::NotFinite && !find_inverted(e, true)) return {};
  const std::vector<NarrowGap> crushed = crushed_gaps(e);
  const bool presses = !crushed.empty() && !e.pushing.empty();
  if (e.solve.status != SolveStatus::Blocked && e.prescribed_arrived && !presses) return {};
  // What touches one prescribed part only could go along with it: it is too heavy, or comes too fast.
  if (!e.is_between && !crushed.empty()) return judge_load(e, settings);
  return blocked(e, crushed);
}

/// The last attempts, in which prescribed parts hardly move, may end otherwise than the first, which they
/// have blocked.
Verdict judge_earlier_attempts(const StepEvidence& e) {
  const auto was_blocked = [](const Attempt& attempt) { return attempt.status == SolveStatus::Blocked; };
  if (!is_stuck(e.solve.status) || e.pushing.empty() || std::ranges::none_of(e.attempts, was_blocked))
    return {};
  return blocked(e, crushed_gaps(e));
}

bool is_overwhelming(const StepEvidence& e) {
  return e.actuator && e.actuator->reach(e.time_step) > kOverwhelming;
}

std::string actuator_text(const StepEvidence& e) {
  const StrongActuator& actuator = *e.actuator;
  std::string text = "actuator '" + actuator.name + "' accelerates " + place_text(actuator.at) + " with " +
                     rough_text(actuator.acceleration, "m/s^2");
  if (!is_overwhelming(e)) return text;
  const double reach = actuator.reach(e.time_step);
  return text + ", which " +
         (actuator.is_turn ? "turns it by " + rough_text(reach, "rad")
                           : "moves it by " + rough_text(reach, "1") + " times the size of the scene") +
         " within " + rough_text(e.time_step, "s");
}

/// Where all joints hold at the start of a step in which nothing prescribed pulls, they can hold at its end,
/// too: there.
bool is_forced_apart(const StepEvidence& e) {
  return e.solve.status == SolveStatus::ConstraintViolated && e.joints_held;
}

Verdict judge_overload(const StepEvidence& e) {
  if (!is_forced_apart(e) && !is_overwhelming(e)) return {};
  std::vector<std::string> findings, bodies;
  if (is_forced_apart(e))
    findings.push_back(e.joint_violation.substr(0, e.joint_violation.find("; ")) +
                       " under forces that are too strong for it, as it could stay where the step starts");
  if (e.actuator) {
    findings.push_back(actuator_text(e));
    bodies.push_back(e.actuator->at.body);
  }
  if (!e.gaps.empty()) {
    findings.push_back(gap_text(e.gaps.front()));
    bodies.insert(bodies.end(), {e.gaps.front().a.body, e.gaps.front().b.body});
  }
  std::string what;
  for (const std::string& finding : findings) what += (what.empty() ? "" : "; ") + finding;
  return {FailureCause::Overload, what,
          "lower the efforts, caps and speeds that act on these bodies, or make light ones heavier", bodies};
}

/// Bodies that would change places because an actuator throws them there: in this step, or one of them in the
/// steps before, with a speed that it gives its body within a full step.
Verdict judge_thrown(const StepEvidence& e, double full_step) {
  if (!e.actuator) return {};
  const double h = e.time_step, motion = e.actuator->acceleration * h * h;
  const BlockingPair& pair = *e.in_the_way;
  const double speed = e.motion / h, full_speed = e.actuator->acceleration * full_step;
  const bool meets = e.actuator->at.body == pair.a.body || e.actuator->at.body == pair.b.body;
  const bool is_thrown = motion > kDriven * e.motion, was_thrown = meets && full_speed > kDriven * speed;
  if (!is_thrown && !was_thrown) return {};
  const std::string within = " within " + rough_text(is_thrown ? h : full_step, "s");
  const std::string what = is_overwhelming(e) ? ""
                           : is_thrown        ? ", by " + rough_text(motion, "m") + within
                                              : ", to " + rough_text(full_speed, "m/s") + within;
  return {FailureCause::Overload,
          actuator_text(e) + what + ": " + place_text(pair.a) + " and " + place_text(pair.b) +
              " would change places",
          "lower the efforts, caps and speeds that act on these bodies, or make light ones heavier",
          {e.actuator->at.body, pair.a.body, pair.b.body}};
}

Verdict judge_not_finite(const StepEvidence& e) {
  if (e.solve.status != SolveStatus::NotFinite) return {};
  if (const StrainedElement* element = find_inverted(e, false))
    return {FailureCause::InvertedElement,
            element_text(*element) + ", where its law has no finite energy",
            "start from a shape without inverted elements (initial_positions, pins), or use a law that "
            "stands inversion, such as stable_neo_hookean",
            {element->at.body}};
  std::vector<std::string> bodies;
  if (!e.not_finite_update.empty())
    return {
        FailureCause::NotFinite,
        e.not_finite_update + " would get a value that is not finite, in " + place_text(e.not_finite.front()),
        "look for divisions by zero, roots and logarithms of negative numbers in what the law returns for "
        "it, and guard them with where/select, or keep the body from getting there",
        {e.not_finite.front().body}};
  std::string what = "an energy or its derivatives are not finite";
  if (!e.not_finite.empty()) {
    what += ": that of " + place_text(e.not_finite.front());
    bodies.push_back(e.not_finite.front().body);
  }
  return {
      FailureCause::NotFinite, what,
      "look for the norm of a zero vector, divisions by zero, roots and logarithms of negative numbers in "
      "its formula, for collapsed elements, and for numbers too large to square",
      bodies};
}

/// Whether a value that misses its tolerance does so because of rounding alone.
bool is_rounding(double tolerance, double value, double rounding) {
  return tolerance < rounding && value < kRoundingRange * rounding;
}

/// Whether Newton's steps, taken in full, have become too small to change anything, while nothing is pressed
/// to a gap that is as small: what is left is rounding then, whatever the estimate of it says.
bool stands_still(const StepEvidence& e, const NewtonSettings& newton) {
  return newton.step_tolerance > 0.0 &&
         e.solve.last_motion < kStandstill * newton.step_tolerance * e.time_step && crushed_gaps(e).empty();
}

/// What may be added to a remedy about energies of the user.
std::string with_acting(const StepEvidence& e) {
  const std::string text = acting_text(e);
  return text.empty() ? "" : "; " + text;
}

/// Near a solution the force of what is stiff is the rounding of its coordinate.
std::string tolerance_remedy(const StepEvidence& e) {
  const double farthest = e.forces.empty() ? 0.0 : max_abs(e.forces.front().position);
  if (farthest > kFar * e.scene_size)
    return "move the scene to the origin: its coordinates of " + rough_text(farthest, "m") + " round by " +
           rough_text(farthest * std::numeric_limits<double>::epsilon(), "m");
  std::string text = "raise them above the rounding";
  if (e.actuator && e.actuator->acceleration > kRounded * e.solve.acceleration)
    text += ", or lower the cap, the stiffness or the effort of actuator '" + e.actuator->name +
            "', whose force on " + place_text(e.actuator->at) + " rounds";
  return text + "; what is very stiff rounds more" + with_acting(e);
}

Verdict judge_tolerance(const StepEvidence& e, const NewtonSettings& newton) {
  if (e.solve.status != SolveStatus::MaxIterations && e.solve.status != SolveStatus::LineSearchFailed)
    return {};
  struct Test {
    const char *name, *unit;
    double tolerance, value, rounding;
  };
  const double speed = e.solve.last_motion / e.time_step;
  const bool is_still = stands_still(e, newton);
  std::string missed;
  for (const Test& t :
       {Test{"newton.acceleration_tolerance", "m/s^2", newton.acceleration_tolerance, e.solve.acceleration,
             e.acceleration_rounding},
        Test{"newton.residual_tolerance", "N", newton.residual_tolerance, e.solve.residual, e.force_rounding},
        Test{"newton.step_tolerance", "m/s", newton.step_tolerance, speed, e.speed_rounding / e.time_step}}) {
    if (t.tolerance <= 0.0 || t.value < t.tolerance) continue;
    if (!is_still && !is_rounding(t.tolerance, t.value, t.rounding)) return {};
    missed += (missed.empty() ? "" : ", ") + std::string(t.name) + " = " + quantity_text(t.tolerance, t.unit);
    if (t.tolerance < t.rounding)
      missed += " (rounding: about " + rough_text(t.rounding, t.unit) + ", reached: ";
    else
      missed += " (reached: ";
    missed += rough_text(t.value, t.unit) + ")";
  }
  if (missed.empty()) return {};
  if (is_still)
    missed += "; another Newton step would move nothing by more than " + rough_text(e.solve.last_motion, "m");
  return {FailureCause::ToleranceBelowRoundOff, "tolerances are below what rounding allows: " + missed,
          tolerance_remedy(e),
          e.forces.empty() ? std::vector<std::string>{} : std::vector<std::string>{e.forces.front().at.body}};
}

Verdict judge_equilibrium(const StepEvidence& e, const Settings& settings) {
  const bool has_inertia = stark::has_inertia(settings.time.integrator);
  if (e.solve.status == SolveStatus::RunAway && has_inertia)
    return {FailureCause::Overload,
            e.fastest.body + " would move faster than light, at " + rough_text(e.motion / e.time_step, "m/s"),
            "look for forces that are too strong for what they move, such as those of a control loop that "
            "swings up: what the loop sets from velocities acts a step late, so it needs a gain below mass "
            "over time step; a spring_damper or a velocity_motor of a joint has no such limit",
            {e.fastest.body}};
  const bool runs_away =
      e.solve.status == SolveStatus::RunAway || (!has_inertia && e.motion > kRunaway * e.scene_size);
  if (!runs_away) return {};
  return {FailureCause::NoEquilibrium,
          "nothing balances the forces on " +
              (e.forces.empty() ? std::string("the bodies") : e.forces.front().at.body) + ": it moved by " +
              rough_text(e.motion, "m") + " in a quasistatic step of a scene of " +
              rough_text(e.scene_size, "m"),
          "where it is free, pin it, put it on something, or use an integrator with inertia such as "
          "implicit_euler; where it is held, the load is more than it can carry, as beyond buckling or "
          "yielding: load it less, or by prescribed displacements",
          e.forces.empty() ? std::vector<std::string>{} : std::vector<std::string>{e.forces.front().at.body}};
}

Verdict judge_overlap(const StepEvidence& e) {
  if (!e.is_first_step || e.start_gaps.empty() || e.start_gaps.front().ratio() > kOverlap) return {};
  const NarrowGap& gap = e.start_gaps.front();
  return {FailureCause::ThicknessOverlap,
          "bodies overlap in thickness at the start: " + gap_text(gap),
          "move them at least " + rough_text(gap.contact_distance, "m") +
              " apart, or give them a smaller contact_distance",
          {gap.a.body, gap.b.body}};
}

Verdict judge_detour(const StepEvidence& e) {
  std::string what = "the way to where Newton's method brought the bodies, by at most " +
                     rough_text(e.motion, "m") + ", is not clear";
  std::vector<std::string> bodies;
  if (e.in_the_way) {
    bodies = {e.in_the_way->a.body, e.in_the_way->b.body};
    what += ": " + place_text(e.in_the_way->a) + " and " + place_text(e.in_the_way->b) + " meet on it";
  }
  return {FailureCause::Detour, what,
          "lower time.min_step until bodies move by less than their size in it, or make them slower", bodies};
}

Verdict judge_status(const StepEvidence& e, const Settings& settings) {
  switch (e.solve.status) {
    case SolveStatus::Detour:
      return judge_detour(e);
    case SolveStatus::LinearSolveFailed:
      if (e.stiffness_ratio > kContrastOfSolve) break;
      return {FailureCause::SingularSystem, force_text(e),
              has_inertia(settings.time.integrator)
                  ? "look for free bodies without inertia or support, and use linear.solver = 'cholesky'"
                  : "look for bodies that nothing holds, which quasistatic steps cannot move: friction holds "
                    "nothing in a first step, and no more than its limit later; go on from the state of a "
                    "simulation with inertia, pin them, or load them less"};
    default:
      break;
  }
  if (e.stiffness_ratio > (e.solve.status == SolveStatus::LinearSolveFailed ? kContrastOfSolve : kContrast))
    return judge_contrast(e);
  if (e.solve.status == SolveStatus::MaxIterations)
    return {
        FailureCause::IterationBudget,
        "Newton's method was still on its way after newton.max_iterations; " + force_text(e),
        has_inertia(settings.time.integrator)
            ? "raise newton.max_iterations, lower time.step, or loosen the tolerances" + with_acting(e)
            : "raise newton.max_iterations, apply loads and prescribed motion in smaller parts, or loosen "
              "the tolerances" +
                  with_acting(e)};
  const std::string first = acting_text(e);
  return {FailureCause::Unknown, force_text(e),
          (first.empty() ? "" : first + "; ") +
              "look at the bodies named here, for over-constrained parts and for extreme stiffness; "
              "write_reproducer(path) keeps the step for study"};
}

std::string suspicion_text(const StepEvidence& e) {
  return "numbers look as if in other units: " + e.unit_suspicions.front();
}

Verdict find_cause(const StepEvidence& e, const Settings& settings) {
  switch (e.solve.status) {
    case SolveStatus::Interrupted:
      return {FailureCause::Interrupted, "interrupted", "go on with another step"};
    case SolveStatus::TimeBudget:
      return {FailureCause::TimeBudget,
              std::to_string(e.solve.iterations) + " iterations in " + std::to_string(e.attempts.size()) +
                  " attempts took longer than " + quantity_text(settings.newton.max_seconds, "s") + "; " +
                  force_text(e),
              "raise newton.max_seconds, make the scene smaller, or lower time.step"};
    case SolveStatus::ConstraintViolated: {
      for (Verdict verdict : {judge_load(e, settings), judge_overload(e)})
        if (verdict.cause != FailureCause::None) return verdict;
      const size_t end = e.joint_violation.find("; ");
      return {FailureCause::ContradictingJoints, e.joint_violation.substr(0, end),
              end == std::string::npos ? "look for joints that contradict each other"
                                       : e.joint_violation.substr(end + 2)};
    }
    default:
      break;
  }
  for (Verdict verdict :
       {judge_prescribed(e, settings), judge_not_finite(e), judge_users_energies(e),
        judge_tolerance(e, settings.newton), judge_equilibrium(e, settings), judge_pins(e), judge_overlap(e)})
    if (verdict.cause != FailureCause::None) return verdict;
  if (e.solve.status == SolveStatus::Detour && e.in_the_way) {
    Verdict thrown = judge_thrown(e, settings.time.step);
    return thrown.cause != FailureCause::None ? thrown : judge_detour(e);
  }
  for (Verdict verdict :
       {judge_load(e, settings), judge_overload(e), judge_earlier_attempts(e), judge_flattened(e)})
    if (verdict.cause != FailureCause::None) return verdict;
  if (!e.unit_suspicions.empty())
    return {FailureCause::UnitMistake, suspicion_text(e),
            "check the units of all that is named here; lengths are in m, masses in kg, times in s"};
  return judge_status(e, settings);
}

}  // namespace

std::string place_text(const BodyVertices& place) {
  if (place.vertices.empty()) return place.body;
  std::string text = place.body + (place.vertices.size() == 1 ? " (vertex " : " (vertices ");
  for (size_t k = 0; k < std::min(kNamedVertices, place.vertices.size()); ++k)
    text += (k > 0 ? ", " : "") + std::to_string(place.vertices[k]);
  return text + (place.vertices.size() > kNamedVertices ? ", ...)" : ")");
}

Diagnosis judge(StepEvidence evidence, const Settings& settings) {
  Verdict verdict = find_cause(evidence, settings);
  Diagnosis diagnosis{
      .cause = verdict.cause, .finding = std::move(verdict.finding), .remedy = std::move(verdict.remedy)};
  // Measured, but it may come from a number in another unit.
  if ((verdict.cause == FailureCause::CrushingLoad || verdict.cause == FailureCause::Overload) &&
      !evidence.unit_suspicions.empty())
    diagnosis.remedy += "; " + suspicion_text(evidence);
  const auto add = [&](const std::string& body) {
    if (!body.empty() && std::ranges::find(diagnosis.bodies, body) == diagnosis.bodies.end())
      diagnosis.bodies.push_back(body);
  };
  for (const std::string& body : verdict.bodies) add(body);
  if (verdict.bodies.empty()) {
    for (const UnbalancedForce& force : evidence.forces) add(force.at.body);
    if (evidence.blocking) add(evidence.blocking->a.body), add(evidence.blocking->b.body);
  }
  diagnosis.evidence = std::move(evidence);
  return diagnosis;
}

}  // namespace stark
