#include <stark/sim/step/diagnosis.h>

#include <doctest/doctest.h>

using namespace stark;

namespace {

BodyVertices sheet(std::vector<int32_t> vertices) { return {"cloth 'sheet'", std::move(vertices)}; }

/// A step that used up its iterations, with nothing special about it.
StepEvidence plain() {
  StepEvidence evidence;
  evidence.solve.status = SolveStatus::MaxIterations;
  evidence.solve.residual = 2.0;
  evidence.solve.acceleration = 3.0;
  evidence.solve.last_motion = 0.01;
  evidence.time_step = 0.01;
  evidence.scene_size = 1.0;
  evidence.motion = 0.1;
  evidence.forces = {{sheet({7}), {1, 2, 3}, 2.0, 3.0}};
  return evidence;
}

Diagnosis judged(const StepEvidence& evidence, const Settings& settings = {}) {
  Diagnosis diagnosis = judge(evidence, settings);
  CHECK_FALSE(diagnosis.finding.empty());
  CHECK_FALSE(diagnosis.remedy.empty());
  return diagnosis;
}

bool names(const Diagnosis& diagnosis, const std::string& text) {
  return diagnosis.finding.find(text) != std::string::npos;
}

}  // namespace

TEST_CASE("places name at most four vertices") {
  CHECK(place_text({"rigid body 'box'"}) == "rigid body 'box'");
  CHECK(place_text(sheet({3})) == "cloth 'sheet' (vertex 3)");
  CHECK(place_text(sheet({3, 4})) == "cloth 'sheet' (vertices 3, 4)");
  CHECK(place_text(sheet({1, 2, 3, 4, 5})) == "cloth 'sheet' (vertices 1, 2, 3, 4, ...)");
}

TEST_CASE("a step with nothing wrong in sight ran out of iterations, or has no known cause") {
  const Diagnosis budget = judged(plain());
  CHECK(budget.cause == FailureCause::IterationBudget);
  CHECK(names(budget, "2 N"));
  CHECK(names(budget, "cloth 'sheet' (vertex 7)"));
  CHECK(budget.bodies == std::vector<std::string>{"cloth 'sheet'"});
  StepEvidence lost = plain();
  lost.solve.status = SolveStatus::LineSearchFailed;
  CHECK(judged(lost).cause == FailureCause::Unknown);
  StepEvidence detour = plain();
  detour.solve.status = SolveStatus::Detour;
  CHECK(judged(detour).cause == FailureCause::Detour);
  // A pair that meets is certain, numbers far from ordinary are not.
  detour.unit_suspicions = {"rigid body 'grain': extent of the mesh = 4e-05 m"};
  CHECK(judged(detour).cause == FailureCause::UnitMistake);
  detour.in_the_way.emplace();
  CHECK(judged(detour).cause == FailureCause::Detour);
}

TEST_CASE("blocked motion names who pushes and what is in the way") {
  StepEvidence evidence = plain();
  evidence.solve.status = SolveStatus::Blocked;
  evidence.prescribed_arrived = false;
  evidence.pushing = {"rigid body 'press'"};
  evidence.blocking = BlockingPair{sheet({3}), {"rigid body 'table'", {0, 1, 2}}, 0.001};
  const Diagnosis diagnosis = judged(evidence);
  CHECK(diagnosis.cause == FailureCause::BlockedMotion);
  CHECK(names(diagnosis, "rigid body 'press' cannot get where prescribed"));
  CHECK(names(diagnosis, "cloth 'sheet' (vertex 3) and rigid body 'table' (vertices 0, 1, 2) allow 0.1 %"));
  CHECK(diagnosis.bodies ==
        std::vector<std::string>{"rigid body 'press'", "cloth 'sheet'", "rigid body 'table'"});
  // Nothing touches, but an element between pins would turn inside out.
  evidence.elements = {
      {.at = sheet({1, 2, 3}), .element = 4, .stretch = 0.1, .size = -0.1, .is_prescribed = true}};
  CHECK(judged(evidence).cause == FailureCause::OverconstrainedPins);
}

TEST_CASE(
    "a prescribed body that crushes what is in between has been blocked, wherever Newton's method gave up") {
  StepEvidence evidence = plain();
  evidence.pushing = {"rigid body 'press'"};
  evidence.gaps = {{{"rigid body 'bag'"}, {"rigid body 'press'"}, 1e-5, 2e-3},
                   {{"rigid body 'bag'"}, {"rigid body 'floor'"}, 1.1e-5, 2e-3}};
  const Diagnosis diagnosis = judged(evidence);
  CHECK(diagnosis.cause == FailureCause::BlockedMotion);
  CHECK(diagnosis.bodies ==
        std::vector<std::string>{"rigid body 'press'", "rigid body 'bag'", "rigid body 'floor'"});
  evidence.gaps[0].distance = evidence.gaps[1].distance = 1e-3;
  CHECK(judged(evidence).cause == FailureCause::IterationBudget);
}

TEST_CASE("prescribed parts that stand where energies have no value are not blocked") {
  StepEvidence evidence = plain();
  evidence.solve.status = SolveStatus::NotFinite;
  evidence.prescribed_arrived = false;
  evidence.pushing = {"rigid body 'lid'"};
  evidence.gaps = {{{"rigid body 'ball'"}, {"rigid body 'ground'"}, 1.6e-4, 7.9e-4}};
  CHECK(judged(evidence).cause == FailureCause::NotFinite);
  evidence.solve.status = SolveStatus::Blocked;
  CHECK(judged(evidence).cause == FailureCause::BlockedMotion);
}

TEST_CASE("what runs into one prescribed body, and touches nothing else, is not blocked by it") {
  StepEvidence evidence = plain();
  evidence.solve.status = SolveStatus::Blocked;
  evidence.prescribed_arrived = false;
  evidence.pushing = {"rigid body 'shell'"};
  evidence.gaps = {{{"rigid body 'needle'"}, {"rigid body 'shell'"}, 6.6e-7, 6.6e-4}};
  CHECK(judged(evidence).cause == FailureCause::BlockedMotion);
  evidence.is_between = false;
  const Diagnosis diagnosis = judged(evidence);
  CHECK(diagnosis.cause == FailureCause::CrushingLoad);
  CHECK(names(diagnosis, "rigid body 'needle' is 6.6e-07 m from rigid body 'shell'"));
  evidence.gaps[0].distance = 1e-4;  // not pressed
  CHECK(judged(evidence).cause == FailureCause::BlockedMotion);
}

TEST_CASE("forces that crush are named before joints that they pull apart") {
  StepEvidence evidence = plain();
  evidence.solve.status = SolveStatus::ConstraintViolated;
  evidence.joint_violation = "joint 'slide' is apart by 1 mm; look at it";
  CHECK(judged(evidence).cause == FailureCause::ContradictingJoints);
  evidence.gaps = {{{"rigid body 'cube'"}, {"rigid body 'finger'"}, 2e-6, 2e-3}};
  const Diagnosis diagnosis = judged(evidence);
  CHECK(diagnosis.cause == FailureCause::CrushingLoad);
  CHECK(names(diagnosis, "rigid body 'cube' is 2e-06 m from rigid body 'finger'"));
}

TEST_CASE("joints that hold where a step starts, and that nothing prescribed pulls, are forced apart") {
  StepEvidence evidence = plain();
  evidence.solve.status = SolveStatus::ConstraintViolated;
  evidence.joint_violation = "joint 'slide' is apart by 1 mm; look at it";
  evidence.actuator = StrongActuator{"motor", {"rigid body 'finger'"}, 1e3, false, 1.0};
  CHECK(judged(evidence).cause == FailureCause::ContradictingJoints);
  evidence.joints_held = true;
  const Diagnosis diagnosis = judged(evidence);
  CHECK(diagnosis.cause == FailureCause::Overload);
  CHECK(names(diagnosis, "joint 'slide' is apart by 1 mm under forces that are too strong"));
  CHECK(names(diagnosis, "actuator 'motor' accelerates rigid body 'finger' with 1000 m/s^2"));
  CHECK(diagnosis.bodies == std::vector<std::string>{"rigid body 'finger'"});
}

TEST_CASE("an actuator that no step follows is named, for what it turns or moves") {
  StepEvidence evidence = plain();
  evidence.solve.status = SolveStatus::LineSearchFailed;
  evidence.time_step = 1e-6;
  evidence.actuator = StrongActuator{"effort", {"rigid body 'speck'"}, 6e9, true, 0.01};
  const Diagnosis turned = judged(evidence);
  CHECK(turned.cause == FailureCause::Overload);
  CHECK(names(turned, "turns it by 0.6 rad within 1e-06 s"));
  evidence.actuator->size = 0.1;
  CHECK(judged(evidence).cause == FailureCause::Unknown);
  evidence.actuator = StrongActuator{"effort", {"rigid body 'speck'"}, 2e12, false, 1.0};
  CHECK(names(judged(evidence), "moves it by 2 times the size of the scene"));
  evidence.unit_suspicions = {"rigid body 'speck': extent of the mesh = 4e-05 m"};
  const Diagnosis suspicious = judged(evidence);
  CHECK(suspicious.cause == FailureCause::Overload);
  CHECK(suspicious.remedy.find("numbers look as if in other units") != std::string::npos);
}

TEST_CASE("what crushes is measured and comes before numbers that look as if in other units") {
  StepEvidence evidence = plain();
  evidence.unit_suspicions = {"rigid body 'grain': extent of the mesh = 4e-05 m"};
  CHECK(judged(evidence).cause == FailureCause::UnitMistake);
  evidence.gaps = {{{"rigid body 'grain'"}, {"rigid body 'bullet'"}, 2e-6, 2e-3}};
  const Diagnosis diagnosis = judged(evidence);
  CHECK(diagnosis.cause == FailureCause::CrushingLoad);
  CHECK(diagnosis.remedy.find("extent of the mesh = 4e-05 m") != std::string::npos);
}

TEST_CASE("impacts at hundreds of metres a second are advised shorter steps; who released bodies is named") {
  StepEvidence evidence = plain();
  evidence.gaps = {{{"rigid body 'bullet'"}, {"rigid body 'plate'"}, 1e-6, 1e-3}};
  evidence.fastest = {"rigid body 'bullet'"};
  evidence.time_step = 1e-6;
  evidence.motion = 5e-5;
  const Diagnosis slow = judged(evidence);
  CHECK(slow.cause == FailureCause::CrushingLoad);
  CHECK(slow.remedy.find("min_step") == std::string::npos);
  CHECK_FALSE(names(slow, "released"));
  evidence.motion = 6e-4;
  evidence.released_by = "joint 'holder'";
  const Diagnosis fast = judged(evidence);
  CHECK(fast.cause == FailureCause::CrushingLoad);
  CHECK(fast.remedy.find("or lower time.min_step = 1e-06 s, in which rigid body 'bullet' moves by 6e-04 m at "
                         "600 m/s") != std::string::npos);
  CHECK(names(fast, "joint 'holder' was released, so they touch"));
}

TEST_CASE("what prescribed motion has blocked in longer attempts is blocked motion") {
  StepEvidence evidence = plain();
  evidence.gaps = {{sheet({0}), sheet({6}), 1e-5, 9e-5}};
  evidence.attempts = {{1e-3, SolveStatus::Blocked, 19}, {1e-6, SolveStatus::MaxIterations, 200}};
  CHECK(judged(evidence).cause == FailureCause::IterationBudget);
  evidence.pushing = {"rigid body 'jaw'"};
  const Diagnosis diagnosis = judged(evidence);
  CHECK(diagnosis.cause == FailureCause::BlockedMotion);
  CHECK(names(diagnosis, "rigid body 'jaw' cannot get where prescribed"));
}

TEST_CASE("what meets on the way is named") {
  StepEvidence evidence = plain();
  evidence.solve.status = SolveStatus::Detour;
  evidence.in_the_way = BlockingPair{sheet({3}), {"rigid body 'ball'", {4}}, 0.2};
  const Diagnosis diagnosis = judged(evidence);
  CHECK(diagnosis.cause == FailureCause::Detour);
  CHECK(names(diagnosis, "cloth 'sheet' (vertex 3) and rigid body 'ball' (vertex 4)"));
  CHECK(diagnosis.bodies == std::vector<std::string>{"cloth 'sheet'", "rigid body 'ball'"});
}

TEST_CASE("bodies that an actuator throws into each other's places are overloaded") {
  StepEvidence evidence = plain();
  evidence.solve.status = SolveStatus::Detour;
  evidence.in_the_way = BlockingPair{{"rigid body 'speck'", {1}}, {"rigid body 'box'", {4}}, 0.2};
  evidence.time_step = 1e-6;
  evidence.actuator = StrongActuator{"effort", {"rigid body 'speck'"}, 1e11, false, 1.0};
  const Diagnosis diagnosis = judged(evidence);  // by 0.1 m, which is how far it comes
  CHECK(diagnosis.cause == FailureCause::Overload);
  CHECK(names(diagnosis, "actuator 'effort' accelerates rigid body 'speck' with"));
  CHECK(
      names(diagnosis, "rigid body 'speck' (vertex 1) and rigid body 'box' (vertex 4) would change places"));
  CHECK(diagnosis.bodies == std::vector<std::string>{"rigid body 'speck'", "rigid body 'box'"});
  evidence.actuator->acceleration = 1e6;  // too little to give it its speed of 1e5 m/s
  CHECK(judged(evidence).cause == FailureCause::Detour);
}

TEST_CASE("bodies that meet at the speed that an actuator gives one of them in a full step are overloaded") {
  StepEvidence evidence = plain();
  evidence.solve.status = SolveStatus::Detour;
  evidence.in_the_way = BlockingPair{{"rigid body 'speck'", {1}}, {"rigid body 'box'", {4}}, 0.2};
  evidence.time_step = 1e-6;
  evidence.actuator = StrongActuator{"effort", {"rigid body 'speck'"}, 1e8, false, 1.0};
  Settings settings;
  settings.time.step = 0.01;  // to 1e6 m/s, when it moves at 1e5
  const Diagnosis diagnosis = judged(evidence, settings);
  CHECK(diagnosis.cause == FailureCause::Overload);
  CHECK(names(diagnosis, "accelerates rigid body 'speck' with 1e+08 m/s^2, to 1e+06 m/s within 0.01 s"));
  settings.time.step = 1e-4;
  CHECK(judged(evidence, settings).cause == FailureCause::Detour);
  settings.time.step = 0.01;
  evidence.actuator->at = {"rigid body 'fan'"};  // that meets nothing
  CHECK(judged(evidence, settings).cause == FailureCause::Detour);
}

TEST_CASE("an energy without a bound comes before what follows from it") {
  StepEvidence evidence = plain();
  evidence.stiffness_ratio = 1e18;
  evidence.steep = SteepEnergy{sheet({3}), "gravity", 1e12, 1e-9};
  const Diagnosis diagnosis = judged(evidence);
  CHECK(diagnosis.cause == FailureCause::SingularEnergy);
  CHECK(names(diagnosis, "energy 'gravity'"));
  CHECK(diagnosis.bodies == std::vector<std::string>{"cloth 'sheet'"});
}

TEST_CASE("a kink or a jump of a user's energy comes before tolerances, energies that act are named after") {
  StepEvidence evidence = plain();
  evidence.solve.status = SolveStatus::LineSearchFailed;
  evidence.acting = {"groove", "spring"};
  const Diagnosis unknown = judged(evidence);
  CHECK(unknown.cause == FailureCause::Unknown);
  CHECK(unknown.remedy.starts_with("energies 'groove' and 'spring' act there: print(energy.check())"));
  evidence.rough = RoughEnergy{sheet({3}), "groove", 0.0, 2.0};
  const Diagnosis kink = judged(evidence);
  CHECK(kink.cause == FailureCause::RoughEnergy);
  CHECK(names(kink,
              "energy 'groove' has a kink where cloth 'sheet' (vertex 3) is: its force jumps there by 2 N"));
  evidence.rough->jump = 0.1;
  CHECK(names(judged(evidence), "jumps by 0.1 J"));
}

TEST_CASE("what a material would remember is named with its law") {
  StepEvidence evidence = plain();
  evidence.solve.status = SolveStatus::NotFinite;
  evidence.not_finite = {sheet({3})};
  evidence.not_finite_update = "internal variable 'flow' of law 'maxwell'";
  const Diagnosis diagnosis = judged(evidence);
  CHECK(diagnosis.cause == FailureCause::NotFinite);
  CHECK(names(diagnosis, "internal variable 'flow' of law 'maxwell' would get a value that is not finite"));
}

TEST_CASE("pins that pull a body far apart over-constrain it") {
  StepEvidence evidence = plain();
  evidence.pins = PinPair{sheet({0, 8}), 0.9, 0.3};
  const Diagnosis diagnosis = judged(evidence);
  CHECK(diagnosis.cause == FailureCause::OverconstrainedPins);
  CHECK(names(diagnosis, "cloth 'sheet' (vertices 0, 8)"));
  CHECK(names(diagnosis, "3 times the length"));
  evidence.pins = PinPair{sheet({0, 8}), 0.33, 0.3};
  CHECK(judged(evidence).cause == FailureCause::IterationBudget);
}

TEST_CASE("energies that are not finite are those of inverted elements, or of who owns them") {
  StepEvidence evidence = plain();
  evidence.solve.status = SolveStatus::NotFinite;
  evidence.not_finite = {{"energy 'spring'", {2}}};
  CHECK(judged(evidence).cause == FailureCause::NotFinite);
  CHECK(names(judged(evidence), "energy 'spring' (vertex 2)"));
  evidence.elements = {{.at = {"solid 'cube'", {1, 2, 3, 4}}, .element = 17, .size = -0.2}};
  CHECK(judged(evidence).cause == FailureCause::InvertedElement);
  CHECK(names(judged(evidence), "element 17 of solid 'cube'"));
}

TEST_CASE("tolerances count as below rounding only where rounding is all that is left") {
  Settings settings;
  settings.newton.acceleration_tolerance = 1e-9;
  settings.newton.step_tolerance = 0.0;
  StepEvidence evidence = plain();
  evidence.solve.acceleration = 5e-7;
  evidence.acceleration_rounding = 1e-7;
  const Diagnosis diagnosis = judged(evidence, settings);
  CHECK(diagnosis.cause == FailureCause::ToleranceBelowRoundOff);
  CHECK(names(diagnosis, "newton.acceleration_tolerance = 1e-09 m/s^2 (rounding: about 1e-07 m/s^2"));
  // What an actuator does is most of what is left.
  evidence.actuator = StrongActuator{"motor", {"rigid body 'finger'"}, 4e-7, false, 1.0};
  CHECK(judged(evidence, settings)
            .remedy.find("lower the cap, the stiffness or the effort of actuator 'motor'") !=
        std::string::npos);
  evidence.actuator->acceleration = 1e-9;
  CHECK(judged(evidence, settings).remedy == diagnosis.remedy);
  // Far from rounding, the tolerance is not what stands in the way.
  evidence.solve.acceleration = 1.0;
  CHECK(judged(evidence, settings).cause == FailureCause::IterationBudget);
  // Nor is it where another tolerance is missed for real.
  evidence.solve.acceleration = 5e-7;
  settings.newton.residual_tolerance = 1e-3;
  CHECK(judged(evidence, settings).cause == FailureCause::IterationBudget);
}

TEST_CASE("what runs away in a quasistatic step has no equilibrium") {
  Settings settings;
  settings.time.integrator = Integrator::Quasistatic;
  StepEvidence evidence = plain();
  evidence.motion = 1e3;
  CHECK(judged(evidence, settings).cause == FailureCause::NoEquilibrium);
  CHECK(judged(evidence).cause == FailureCause::IterationBudget);  // with inertia it may fly far
  evidence = plain();
  evidence.solve.status = SolveStatus::RunAway;
  CHECK(judged(evidence, settings).cause == FailureCause::NoEquilibrium);
  evidence.fastest = sheet({7});
  evidence.motion = 1.48e7;
  evidence.time_step = 0.01;
  const Diagnosis with_inertia = judged(evidence);
  CHECK(with_inertia.cause == FailureCause::Overload);
  CHECK(with_inertia.finding.find("would move faster than light, at 1.48e+09 m/s") != std::string::npos);
}

TEST_CASE("bodies that start within a tenth of their contact distance overlap in thickness") {
  StepEvidence evidence = plain();
  evidence.start_gaps = {{sheet({1}), {"cloth 'lining'", {4, 5}}, 1e-5, 2e-3}};
  CHECK(judged(evidence).cause == FailureCause::IterationBudget);  // it came there by itself
  evidence.is_first_step = true;
  const Diagnosis diagnosis = judged(evidence);
  CHECK(diagnosis.cause == FailureCause::ThicknessOverlap);
  CHECK(names(diagnosis, "cloth 'lining' (vertices 4, 5)"));
  CHECK(diagnosis.remedy.find("0.002 m") != std::string::npos);
  evidence.start_gaps[0].distance = 1e-3;
  CHECK(judged(evidence).cause == FailureCause::IterationBudget);
}

TEST_CASE("suspicious units are named when nothing more certain is") {
  StepEvidence evidence = plain();
  evidence.unit_suspicions = {"cloth 'sheet': density = 150 kg/m^2"};
  CHECK(judged(evidence).cause == FailureCause::UnitMistake);
  evidence.pins = PinPair{sheet({0, 8}), 0.9, 0.3};
  CHECK(judged(evidence).cause == FailureCause::OverconstrainedPins);
}

TEST_CASE("systems that cannot be solved are singular, or too stiff against what is soft") {
  StepEvidence evidence = plain();
  evidence.solve.status = SolveStatus::LinearSolveFailed;
  CHECK(judged(evidence).cause == FailureCause::SingularSystem);
  evidence.stiffness_ratio = 1e16;
  evidence.stiffest = "solid 'beam'";
  evidence.softest = "cloth 'sheet'";
  const Diagnosis diagnosis = judged(evidence);
  CHECK(diagnosis.cause == FailureCause::StiffnessContrast);
  CHECK(names(diagnosis, "solid 'beam' is 1e+16 times as stiff as cloth 'sheet'"));
  evidence.softest = evidence.stiffest;
  evidence.elements = {{{"solid 'beam'", {1, 2, 3, 4}}, 7, 5e-14, 0.5}};
  const Diagnosis of_one = judged(evidence);
  CHECK(of_one.bodies == std::vector<std::string>{"solid 'beam'"});
  CHECK(names(of_one, "one part of solid 'beam' is 1e+16 times as stiff as another"));
  CHECK(names(of_one,
              "element 7 of solid 'beam' (vertices 1, 2, 3, 4) has 0.5 times its size at rest, with "
              "edges shortened to 5e-14 of theirs"));
}

TEST_CASE("budgets, interruptions and joints have causes of their own") {
  StepEvidence evidence = plain();
  evidence.solve.status = SolveStatus::TimeBudget;
  CHECK(judged(evidence).cause == FailureCause::TimeBudget);
  evidence.solve.status = SolveStatus::Interrupted;
  CHECK(judged(evidence).cause == FailureCause::Interrupted);
  evidence.solve.status = SolveStatus::ConstraintViolated;
  evidence.joint_violation = "joint 'hinge' is apart by 0.1 m; look for joints that contradict each other";
  const Diagnosis diagnosis = judged(evidence);
  CHECK(diagnosis.cause == FailureCause::ContradictingJoints);
  CHECK(diagnosis.finding == "joint 'hinge' is apart by 0.1 m");
  CHECK(diagnosis.remedy == "look for joints that contradict each other");
}
