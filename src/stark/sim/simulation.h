// Simulation: owns the model of a scene, its state and the solver; advances time step by step.
#pragma once

#include <functional>
#include <memory>
#include <optional>
#include <span>
#include <vector>

#include <stark/mechanics/time_integrator.h>
#include <stark/sim/exclusions.h>
#include <stark/sim/model.h>
#include <stark/sim/prescribed.h>
#include <stark/sim/step_report.h>
#include <stark/sim/time_marks.h>
#include <stark/solve/newton.h>

namespace stark {

class Simulation {
 public:
  /// Builds the model. Throws InvalidArgument for settings or scenes that cannot be simulated and
  /// InitialIntersection when surfaces intersect or contain each other at time 0.
  /// `between` is called between the parts of the work; what it throws ends it.
  explicit Simulation(
      const Scene& scene, const Settings& settings = {}, const std::function<void()>& between = [] {});
  ~Simulation();
  Simulation(Simulation&&) noexcept;

  /// Advances by one time step: settings.time.step, or less after failures or when `max_time_step` [s] is
  /// smaller. On failure the state is as before the call.
  const StepReport& step(double max_time_step = 1e300);
  const StepReport& report() const { return report_; }

  double time() const { return state_.time; }
  /// The coming step, if nothing fails and no scripted body turns too far in it.
  PlannedStep next_step(double max_time_step = 1e300) const;
  const State& state() const { return state_; }
  /// Findings about the state that do not prevent a step: bodies within a hundredth of the distance at which
  /// contact starts to push them apart, elements that are inverted.
  std::vector<std::string> check_state() const;
  /// Rewinds or resumes; throws InvalidArgument for a state of another model and for numbers that no state
  /// can have.
  void set_state(const State& state);
  /// Goes on where another simulation of the same scene was, sensors included: takes the step of at most
  /// `max_time_step` [s] that led from `before` to `state` again, so that contacts, reactions and the report
  /// are those of that step. Returns false when it does not come to the same places bit for bit; the state is
  /// then set as by set_state().
  bool resume(const State& before, double max_time_step, const State& state);
  const Model& model() const { return *model_; }
  const Scene& scene() const { return scene_; }
  const Settings& settings() const { return settings_; }
  int32_t dof_count() const { return 3 * model_->map().layout().block_count; }

  /// Positions [m] or velocities [m/s] of the vertices of a body's mesh, in its order.
  std::vector<Vec3> positions(BodyId body) const;
  std::vector<Vec3> velocities(BodyId body) const;
  const std::vector<Index3>& triangles(BodyId body) const;
  /// Pose of a rigid body's mesh frame, velocity [m/s] of its origin and angular velocity [rad/s], world
  /// axes.
  Vec3 position(BodyId body) const;
  Mat3 rotation(BodyId body) const;
  Vec3 linear_velocity(BodyId body) const;
  Vec3 angular_velocity(BodyId body) const;

  /// Pose of a scripted body at the end of the next full time step; afterwards it rests until told otherwise.
  /// With `duration` [s] the pose holds after that time.
  void set_pose(BodyId body, const Vec3& position, const Mat3& rotation, std::optional<double> duration = {});
  /// Where a scripted body is moving to or resting; its pose while it moves at constant velocity.
  void target_pose(BodyId body, Vec3& out_position, Mat3& out_rotation) const;
  /// Velocity of the origin [m/s] and angular velocity [rad/s] of a scripted body from now on.
  void set_velocity(BodyId body, const Vec3& velocity, const Vec3& angular_velocity);
  /// Positions [m] of the pinned vertices, in the order of pinning, at the end of the next full time step.
  /// With `duration` [s] after that time, then for all pins of deformable bodies.
  void set_pin_targets(BodyId body, std::span<const Vec3> targets, std::optional<double> duration = {});
  /// Where the pinned vertices are or are going to [m], in the order of pinning.
  std::vector<Vec3> pin_targets(BodyId body) const;
  /// Frames of the nodes of a rod, axes d1, d2, d3 as columns.
  std::vector<Mat3> frames(BodyId body) const;
  /// Frames of the nodes of fibres, path by path; none without bending.
  std::vector<Mat3> frames(FibresId fibres) const;
  /// Frames of the clamped nodes of a rod, in the order of clamping, at the end of the next full time step.
  void set_clamp_targets(BodyId body, std::span<const Mat3> targets, std::optional<double> duration = {});
  std::vector<Mat3> clamp_targets(BodyId body) const;

  /// Replaces a value of an energy of the scene from now on, without rebuilding anything: as many numbers as
  /// it was added with. Throws InvalidArgument for unknown names, wrong counts and numbers that are not
  /// finite.
  void set_energy_value(EnergyId energy, const std::string& name, std::span<const double> values);
  /// Energies [J] of its elements in the state of the last step.
  std::vector<double> element_energies(EnergyId energy) const;
  /// Forces [N] on the points of its elements in the last step, [element][point].
  std::vector<Vec3> element_forces(EnergyId energy) const;

  /// Releases a joint, or holds it again from the next step on. A joint that is held again must be within
  /// reach: what is apart by then is pulled together at once.
  void set_joint_enabled(JointId joint, bool enabled);
  bool joint_enabled(JointId joint) const;
  /// Coordinates of a joint [m, rad] at the end of the last step; angles count full turns from time 0 on.
  std::vector<double> joint_coordinates(JointId joint) const;
  /// Their rates in the last step [m/s, rad/s]; before the first one, those of the initial velocities.
  std::vector<double> joint_rates(JointId joint) const;
  std::vector<Joint::Coordinate> joint_coordinate_names(JointId joint) const;
  /// What is left of its residuals [m, rad].
  std::vector<double> joint_residuals(JointId joint) const;
  /// Force [N] and torque [N m] of the joint on what carries frame b, about the origin of that frame, in the
  /// last step; what carries frame a gets the opposite. After set_state, of the multipliers of the state,
  /// which differ by what residuals below a hundredth of the tolerance hold.
  Wrench joint_reaction(JointId joint) const;

  /// Replaces a value of an actuator from the next step on: targets, caps, gains. Throws InvalidArgument for
  /// unknown names and forbidden values.
  void set_actuator_value(ActuatorId actuator, const std::string& name, double value);
  double actuator_value(ActuatorId actuator, const std::string& name) const;
  void set_actuator_enabled(ActuatorId actuator, bool enabled);
  bool actuator_enabled(ActuatorId actuator) const;
  /// Force [N] or torque [N m] along its (first) coordinate in the last step, positive where it raises the
  /// coordinate: it acts on frame b of the joint, its opposite on frame a.
  double actuator_effort(ActuatorId actuator) const;
  /// Power [W] that it fed into the motion in the last step.
  double actuator_power(ActuatorId actuator) const;

  /// Releases an attachment, or holds it again from the next step on; broken pairs stay broken.
  void set_attachment_enabled(AttachmentId attachment, bool enabled);
  /// By pair: 1 held, 0 released, -1 broken.
  std::vector<int32_t> attachment_status(AttachmentId attachment) const;
  /// Forces [N] on the points of side a in the last step, zero for pairs that do not hold; what carries them
  /// gets the opposite. After set_state, of the multipliers of the state, as joint_reaction.
  std::vector<Vec3> attachment_forces(AttachmentId attachment) const;

  /// Numbers in State::contact_regained are below this one.
  int64_t exclusion_count() const { return exclusions_.size(); }

  /// The contacts of the last step: who touches whom where, forces and slip. Empty before the first step,
  /// after set_state() and without contact. Groups are indices of bodies, sites those of surface_mesh().
  std::vector<ContactForce> contacts() const;
  /// Acceleration [m/s^2] in the last step of a point of a rigid body, given in the frame of its mesh [m]:
  /// the change of velocity over the time step. Zero before the first step and after set_state().
  Vec3 acceleration(BodyId body, const Vec3& point) const;

  /// Asked between Newton iterations, and within those that take long; returning true ends the step with
  /// status Interrupted.
  void set_interrupt(std::function<bool()> interrupted);
  /// How far the step under way has come, for what set_interrupt() was given.
  StepProgress progress() const;
  /// Threads that it runs on: execution.threads, or less where there are less processors.
  int thread_count() const;

  /// Surfaces for checks and pictures: all sites and the primitives on them.
  const SurfaceMesh& surface_mesh() const;
  std::vector<Vec3> site_positions() const;

 private:
  void check_initial_state() const;
  /// Throws InitialIntersection where surfaces intersect or contain each other at site positions x; `when`
  /// names them: "at time 0".
  void check_clear(std::span<const Vec3> x, const std::string& when) const;
  std::vector<Vec3> site_positions(const State& state) const;
  void check_energies();
  void check_joints();
  ConstraintTolerance joint_tolerance() const;
  /// Multipliers and penalties of a step; `diagonal`: blocks of inertia and elasticity without joints.
  void begin_joints(std::span<const Mat3> diagonal);
  /// Takes the stiffness of joints out of the energies.
  void release_joints();
  void commit_joints();
  void check_actuators();
  /// Joints, actuators and attachments are numbered one after the other.
  bool is_of_actuators(const ConstraintGroup& group) const;
  void check_attachments();
  /// Breaks pairs whose force is above what they stand, with sites at x at the end of a step.
  void commit_attachments(std::span<const Vec3> x);
  /// Which exclusions are over in the coming step.
  void watch_released();
  /// Those of the released exclusions whose sides overlap or touch with sites at x.
  std::vector<int64_t> find_overlapping(const std::vector<int64_t>& released, std::span<const Vec3> x);
  bool is_vertex_inside(int64_t exclusion, std::span<const Vec3> x) const;
  /// Gives bodies that come into contact now the gap that they have for a contact distance, until they part.
  void soften_new_contact(const CloseBodies& before, std::span<const Vec3> x);
  void set_regained(const std::vector<int64_t>& regained);
  void check_regained(const State& state) const;
  /// "'cloth' and 'box' overlap or touch where attachment 'glue' released them".
  std::string overlap_text() const;
  std::string releaser_text() const;
  /// Whether the gap of a contact is swallowed by the rounding of its coordinates.
  static bool is_touching(const Contact& contact, std::span<const Vec3> x);
  void set_attachment_status(const ModelAttachment& attachment, int64_t pair, double status);
  /// Writes the inputs of actuators for a step of length h from step_start_ and reference_.
  void begin_actuators(double h);
  /// Takes efforts and memories over at the end of a step.
  void commit_actuators(std::span<const Vec3> x);
  /// 1 for each joint, then for each actuator, then for each pair of attachments, that acts; actuators of
  /// released joints rest.
  std::vector<double> acting() const;
  std::string violation_text() const;
  double scene_size() const;  ///< [m] diagonal of a box around all bodies
  double checked_duration(const std::string& owner, std::optional<double> duration) const;
  void check_invariance(const PotentialBatch& batch, std::span<const double> element,
                        const std::string& where) const;
  const ModelBody& rigid(BodyId body, const char* what) const;
  const ModelBody& rod(BodyId body) const;
  Configuration start_configuration() const;
  /// Whether the attempt that ends where the potential stands went around something: its iterates followed a
  /// clear path from `start`, but the way that the bodies had to go is not clear.
  bool leads_through_something(const Configuration& start);
  /// Whether something moved so far in the step that it may have gone around something.
  bool moved_far() const;
  /// Whether nothing meets on the way from the start of the step, in `pieces` of equal length in which
  /// vertices go straight.
  bool is_way_clear(const Configuration& start, const Configuration& end, int pieces);
  /// Diagonal blocks of inertia and elasticity at the start of a step: what joints are measured against.
  std::vector<Mat3> natural_stiffness(const Configuration& start);
  Configuration target_configuration(double h) const;
  /// Sets what the velocities of a step of length h are measured from.
  void set_reference(double h);
  /// Rotations and angular momenta of free bodies at the end of a step of length h if nothing acted in it.
  void set_free_rotations(double h);
  /// Angular impulse of a step over its scale [N m] on each body with a free rotation; call it before
  /// anything of the step is taken over.
  std::vector<Vec3> torques();
  /// Takes over the rotation that body b has at the end of a step of length h.
  void commit_rotation(int32_t b, const Vec3& torque, double h);
  /// Angular momentum of body b about its centre of mass [kg m^2/s].
  Vec3 spin(size_t b) const;
  /// Velocity of a point of body b given in its principal frame, relative to the centre of mass [m/s].
  Vec3 turning_velocity(int32_t b, const Vec3& local) const;
  /// Coordinates of joints that their rates are measured from, angles up to full turns [m, rad].
  std::vector<double> reference_coordinates() const;
  /// Gives a batch the positions that it measures velocities and rates from.
  template <typename Batch>
  void set_previous(Batch& batch) const {
    batch.set_previous(reference_.sites);
    if (!reference_.beyond.empty()) batch.set_beyond(reference_.beyond);
  }
  /// Length of a step in which no scripted body turns by more than a sixteenth of a turn [s].
  double longest_turning_step() const;
  /// Predictions and times of all energies, for a step of length h by the integrator.
  void predict(double h);
  /// The same with predictions for `duration`, and inertia and damping of a step of length `scale` [s].
  void predict(double h, double duration, double scale);
  /// Impulses on the free blocks in the step that ends now [N s, N m s].
  struct Impulses {
    std::vector<Vec3> contact;      ///< with friction
    std::vector<Vec3> restitution;  ///< empty without contact
  };
  Impulses contact_impulses();
  std::vector<Vec3> impulses_of(std::span<const PotentialBatch* const> batches) const;
  /// What restitution needs of a step of length h, what it remembers and keeps.
  RestitutionSet::Motion restitution_motion(double h);
  RestitutionMemory restitution_memory() const;
  void remember_impacts(RestitutionMemory memory);
  /// By site [m/s].
  std::vector<Vec3> site_velocities() const;
  /// Keeps the state that a step of length h has started from, for the next one.
  void remember_state(double h);
  struct Motions {
    std::vector<Vec3> point_velocity, body_velocity;  ///< [m/s]
    std::vector<Vec3> spin;                           ///< angular momenta of the bodies [kg m^2/s]
  };
  Motions motions() const;
  /// Keeps what the velocities that were there `before` the step have gained, and how.
  void remember_increments(const Motions& before, const Impulses& impulses, double h);
  /// What the step of length h that starts from the state has of the integrator.
  TimeStencil choose_stencil(double h);
  /// Sites after a step of length h in which nothing pushes [m].
  std::vector<Vec3> free_motion(double h) const;
  bool attempt(double h, SolveReport& total);
  void set_deadline();
  /// Ends the step with the last attempt, of length h; `is_cut`: at the limit of the caller.
  void accept(double h, bool is_cut);
  void add_caveats(double h);
  /// "'gripper' and 'table'", of prescribed bodies that meet in the step that ends at the solution; or empty.
  std::string meeting_text();
  void fail();
  /// Of the last attempt.
  Diagnosis diagnose();
  void commit(double h);
  /// Stored energies of the current state with sites at x; contact is left at zero.
  EnergyLedger stored_energies(std::span<const Vec3> x) const;
  /// Completes the ledger of the step of length h that has just been committed; `before`: stored energies at
  /// its start.
  EnergyLedger balance(const EnergyLedger& before, double h) const;
  double prescribed_work() const;
  double damping_work() const;
  Momentum momentum() const;
  void finish_report(StepStatus status);

  Scene scene_;
  Settings settings_;
  std::unique_ptr<ThreadPool> pool_;
  std::unique_ptr<PhaseTimer> timer_;
  std::unique_ptr<Model> model_;
  std::unique_ptr<Assembler> assembler_;
  std::unique_ptr<ContactPipeline> contact_;
  std::unique_ptr<IncrementalPotential> potential_;
  std::unique_ptr<LinearSolver> linear_solver_;
  std::unique_ptr<NewtonSolver> newton_;
  SurfaceMesh surface_mesh_;
  std::vector<bool> is_filled_;  ///< by body
  Exclusions exclusions_;
  std::vector<int64_t> filtered_;  ///< exclusions that are over in the filter of contact_
  struct Watch {
    std::vector<int64_t> regained{};     ///< exclusions that are over
    std::vector<int64_t> overlapping{};  ///< those that nothing holds, of what is not apart
    CloseBodies close{};
  };
  Watch watch_;  ///< of the step under way
  PrescribedBodies prescribed_;
  State state_;
  StepReport report_;
  struct Reference {
    TimeStencil stencil;
    Configuration place;
    std::vector<Vec3> point_velocity, body_velocity;  ///< v_bar [m/s]
    std::vector<Vec3> contact_velocity;               ///< by body: what contact has added [m/s]
    std::vector<Mat3> body_rotation_rate;             ///< [1/s]
    std::vector<Mat3> free_rotation;                  ///< where the inertia of free bodies brings them
    std::vector<Vec3> angular_momentum;               ///< theirs without what acts in the step [kg m^2/s]
    std::vector<double> joint_rate;                   ///< [m/s, rad/s]
    std::vector<Vec3> sites;                          ///< positions of the sites at `place` [m]
    std::vector<Vec3> friction_sites;                 ///< what slip is measured from [m]
    double friction_duration = 0.0;                   ///< and over what time [s]
    std::vector<Vec3> site_velocities;                ///< at the start of the step, with restitution [m/s]
    // Empty without a history:
    std::vector<Vec3> before;  ///< positions of the sites at the start of the last step [m]
    std::vector<Vec3> beyond;  ///< `sites` and sqrt(1 + 1/c) times their way from the start [m]; or empty
  };
  Reference reference_;
  std::vector<Attempt> attempts_;  ///< of the step under way
  LoadMemory load_;                ///< of its barriers: that of the state, more after attempts that failed
  EnergyLedger energies_before_;   ///< stored at the start of the last attempt
  std::vector<Vec3> step_start_;   ///< site positions that the last step started from [m]
  BlockMatrix diagonal_hessian_;
  std::vector<double> scratch_gradient_;
};

}  // namespace stark
