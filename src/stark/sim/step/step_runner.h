// Takes time steps: attempts with Newton's method, shorter ones where they fail, and the report (step phases
// 0 to 8; the journey in ARCHITECTURE.md).
#pragma once

#include <optional>
#include <string>
#include <vector>

#include <stark/sim/step/diagnosis.h>
#include <stark/sim/step/placing.h>
#include <stark/sim/step/release_watch.h>
#include <stark/sim/step/step_evidence.h>
#include <stark/sim/step/step_joints.h>
#include <stark/sim/step/step_ledger.h>
#include <stark/sim/step/step_report.h>
#include <stark/sim/step/step_way.h>
#include <stark/sim/step/time_marks.h>
#include <stark/solve/newton.h>

namespace stark {

/// Parts of a step that others use, too.
struct StepParts {
  StepMotion& motion;
  StepJoints& joints;
  StepLedger& ledger;
  StepWay& way;
  ReleaseWatch& watch;
  Placing& placing;
};

class StepRunner : private StepPart {
 public:
  StepRunner(const StepContext& context, const StepParts& parts, Assembler& assembler,
             LinearSolver& linear_solver);

  /// Advances the state by one step; on failure it is as before.
  const StepReport& step(double max_time_step);
  const StepReport& report() const { return report_; }
  StepProgress progress() const;
  NewtonSolver& newton() { return newton_; }

 private:
  void begin();
  bool attempt(double h, SolveReport& total);
  /// Sets what the step of length h from `start` is measured from, and the inputs of all energies.
  void predict(double h, const Configuration& start, bool hits_stop);
  /// Length of the attempt that follows one of length h that failed, if any; else ends the step.
  std::optional<double> next_attempt(double h);
  bool may_go_deep(SolveStatus status) const;
  void set_deadline();
  /// Diagonal blocks of inertia and elasticity at the start of a step: what joints are measured against.
  std::vector<Mat3> natural_stiffness(const Configuration& start);
  /// Ends the step with the last attempt, of length h; `is_cut`: at the limit of the caller.
  void accept(double h, bool is_cut);
  void add_caveats(double h);
  void add_caveat(Caveat caveat, const std::string& text);
  /// Measures how near surfaces are, and says it where that is less than settings ask for.
  void report_nearness();
  /// The same of the limits of friction.
  void report_friction();
  void commit(double h);
  void commit_contact(double h);
  void fail();
  /// Whether a step that fails is not halved any more.
  bool is_shortest(double h) const { return 0.5 * h < settings_.time.min_step; }
  /// Takes Newton's method to its end. Where a shorter step would pose the same problem, it goes on from
  /// where its iterations ran out, as often as the step could be halved.
  SolveReport minimize(double h, std::span<const double> guess, SolveReport& total);
  /// Whether something that is free to move did so faster than light in an attempt of length h [s].
  bool is_faster_than_light(double h) const;
  /// Where it ended; `target`, of prescribed parts, must outlive it.
  FailedStep last_attempt(const Configuration& target);
  /// What is said where a kink, a jump or a singular place of a user's energy holds up an attempt of length
  /// h.
  std::string find_energy_at_fault(double h);
  /// Of the last attempt.
  Diagnosis diagnose();
  void finish_report(StepStatus status);

  StepMotion& motion_;
  StepJoints& joints_;
  StepLedger& ledger_;
  StepWay& way_;
  ReleaseWatch& watch_;
  Placing& placing_;
  Assembler& assembler_;
  LinearSolver& linear_solver_;
  NewtonSolver newton_;
  StepReport report_;
  std::vector<Attempt> attempts_;    ///< of the step under way
  bool is_same_if_shorter_ = false;  ///< a step without inertia in which nothing prescribed moves
  int repeats_ = 0;                  ///< of its shortest attempt
  bool goes_deep_ = false;           ///< its last attempt may press below the least distance on the way
  std::string energy_at_fault_;      ///< what is said of it; empty without one
  LoadMemory load_;                  ///< of its barriers: that of the state, more after attempts that failed
  EnergyLedger energies_before_;     ///< stored at the start of the last attempt
  std::vector<double> coordinates_before_;  ///< of joints, at the same time
  std::vector<double> remembered_;          ///< what materials keep of the last attempt
  BlockMatrix diagonal_hessian_;
  std::vector<double> scratch_gradient_;
};

}  // namespace stark
