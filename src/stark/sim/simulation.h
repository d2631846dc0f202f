// Simulation: owns the model of a scene, its state and the solver; advances time step by step.
#pragma once

#include <functional>
#include <memory>
#include <optional>
#include <span>
#include <tuple>
#include <utility>
#include <vector>

#include <stark/collision/intersection.h>
#include <stark/sim/contact_readings.h>
#include <stark/sim/model/energies.h>
#include <stark/sim/model/internal_variables.h>
#include <stark/sim/model/model.h>
#include <stark/sim/site_readings.h>
#include <stark/sim/step/step_report.h>
#include <stark/sim/step/time_marks.h>

namespace stark {

class Placing;
struct Placed;

class Simulation {
 public:
  /// Builds the model. Throws InvalidArgument for settings or scenes that cannot be simulated and
  /// InitialIntersection when surfaces intersect or contain each other at time 0.
  /// `between` is called between the parts of the work; what it throws ends it.
  explicit Simulation(
      const Scene& scene, const Settings& settings = {}, const std::function<void()>& between = [] {});
  ~Simulation();
  Simulation(const Simulation&) = delete;
  Simulation& operator=(const Simulation&) = delete;

  /// Advances by one time step: settings.time.step, or less after failures or when `max_time_step` [s] is
  /// smaller. On failure the state is as before the call.
  const StepReport& step(double max_time_step = 1e300);
  const StepReport& report() const;

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
  /// Rewinds to the start: the state that it was made with.
  void reset();
  /// Goes on where another simulation of the same scene was, sensors included: takes the step of at most
  /// `max_time_step` [s] that led from `before` to `state` again, so that contacts, reactions and the report
  /// are those of that step. Returns false when it does not come to the same places bit for bit; the state is
  /// then set as by set_state(). `placed` [J] is that of the report of the step.
  bool resume(const State& before, double max_time_step, const State& state, double placed = 0.0);
  const Model& model() const { return *model_; }
  const Energies& energies() const { return energies_; }
  const Scene& scene() const { return scene_; }
  const Settings& settings() const { return settings_; }
  int32_t dof_count() const { return 3 * model_->map().layout().block_count; }

  // Placing: free bodies are put elsewhere, or get other velocities, between two steps. Contact, friction,
  // joints and the integrator start anew for them (sim/step/placing.h); sensors read nothing before the next
  // step, whose report has what was placed. Throws InitialIntersection where surfaces meet afterwards, and
  // InvalidArgument where a joint, a limit or an attachment would not hold; then nothing has changed.

  /// From here to end_placing() or cancel_placing() bodies are placed together: checked at the end.
  void begin_placing();
  void end_placing();
  void cancel_placing();
  bool is_placing() const;
  /// What was placed since the last step.
  const Placed& placed() const;
  /// Pose of the mesh frame of a rigid body.
  void place(BodyId body, const Vec3& position, const Mat3& rotation);
  /// Velocity [m/s] of the centre of mass of a rigid body, angular velocity [rad/s].
  void push(BodyId body, const Vec3& velocity, const Vec3& angular_velocity);
  /// Dynamic bodies of any kind, by number, moved as one: p -> rotation p + shift [m]; velocities turn along.
  void place_together(std::span<const int32_t> bodies, const Mat3& rotation, const Vec3& shift);
  /// Positions [m] or velocities [m/s] of all vertices of a deformable body, in the order of its mesh. Pinned
  /// vertices rest where they are placed, and take no velocities.
  void place_vertices(BodyId body, std::span<const Vec3> positions);
  void push_vertices(BodyId body, std::span<const Vec3> velocities);
  /// Coordinates of a joint [m, rad], or their rates [m/s, rad/s]: what hangs on its side b moves as one, or
  /// what hangs on side a where b is held. Throws InvalidArgument where neither hangs on the joint alone.
  void place_joint(JointId joint, std::span<const double> coordinates);
  void push_joint(JointId joint, std::span<const double> rates);

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
  /// Of many rigid bodies at once.
  std::pair<std::vector<Vec3>, std::vector<Mat3>> poses(const std::vector<BodyId>& bodies) const;
  /// Velocity of its centre of mass [m/s]; of the origin of fixed and scripted bodies.
  Vec3 centre_velocity(BodyId body) const;

  /// Pose of a scripted body at the end of the next full time step; afterwards it rests until told otherwise.
  /// With `duration` [s] the pose holds after that time.
  void set_pose(BodyId body, const Vec3& position, const Mat3& rotation, std::optional<double> duration = {});
  /// Where a scripted body is moving to or resting; its pose while it moves at constant velocity.
  std::pair<Vec3, Mat3> target_pose(BodyId body) const;
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
  /// Replaces values of a rest state that the body had when the simulation was made (Scene::set_rest_state),
  /// from now on: one for each element. Throws InvalidArgument for unknown names, wrong counts and forbidden
  /// values.
  void set_rest_state(BodyId body, const std::string& name, std::span<const double> values);
  /// Mean Cauchy stress of each element of a solid [Pa] in the present state, of cloth the mean in its middle
  /// surface times the thickness [N/m]: of the law, limits of Green strain and rest states, whatever the
  /// material remembers; without damping. Empty for other bodies. [theory eq. 10r]
  std::vector<Mat3> mean_stresses(BodyId body);
  /// Of solids of mean dilatation, the volume ratio that the law sees, four numbers for each element: at the
  /// origin of the mesh and slopes along its axes [1/m]. Empty for other bodies. [theory eq. 15c]
  std::vector<double> volume_ratios(BodyId body) const;
  /// What the law of a solid or of the membrane of a cloth remembers; empty for others.
  std::vector<InternalVariable> internal_variables(BodyId body);
  /// Energies [J] of its elements in the state of the last step.
  std::vector<double> element_energies(EnergyId energy) const;
  /// Forces [N] on the points of its elements in the last step, [element][point].
  std::vector<Vec3> element_forces(EnergyId energy) const;
  /// Of an energy of totals: these at the end of the last step, and its derivatives by them; empty for
  /// others.
  TouchingPlane energy_plane(EnergyId energy) const;

  /// Releases a joint, or holds it again from the next step on. A joint that is held again must be within
  /// reach: what is apart by then is pulled together at once.
  void set_joint_enabled(JointId joint, bool enabled);
  /// Throws InvalidArgument where a released joint is further apart than the tolerances, and would be pulled
  /// together if it were held again.
  void check_joint_agrees(JointId joint) const;
  /// Holds a joint from the next step on with side a where it is now, as the carrier of side b sees it.
  /// Throws InvalidArgument for joints that cannot (sim/model/held_places.h) and broken ones.
  void hold_joint_here(JointId joint);
  bool joint_enabled(JointId joint) const;
  /// Whether its force or torque exceeded what it stands: it never holds again.
  bool joint_broken(JointId joint) const;
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
  /// Throws InvalidArgument where what it holds, as gears and stops do, does not hold now, if no bodies are
  /// being placed: the next step would bring it there at once. bdf2 starts anew where such are switched.
  void set_actuator_enabled(ActuatorId actuator, bool enabled);
  bool actuator_enabled(ActuatorId actuator) const;
  /// Force [N] or torque [N m] along its (first) coordinate in the last step, positive where it raises the
  /// coordinate: it acts on frame b of the joint, its opposite on frame a.
  double actuator_effort(ActuatorId actuator) const;
  /// Power [W] that it fed into the motion in the last step.
  double actuator_power(ActuatorId actuator) const;

  /// Motion of the material of a body's surface from the next step on: velocity [m/s] and spin [rad/s] in the
  /// frame of its mesh. Throws InvalidArgument where the scene gave the body none
  /// (Scene::set_surface_motion).
  void set_surface_motion(BodyId body, const Vec3& velocity, const Vec3& spin);
  std::optional<SurfaceMotion> surface_motion(BodyId body) const;  ///< none where the scene gave none

  /// InvalidArgument where released pairs of an attachment are away from where they were at time 0: held
  /// again, they would be thrown there.
  void check_attachment_agrees(AttachmentId attachment) const;
  /// Releases an attachment, or holds it again from the next step on; broken pairs stay broken.
  void set_attachment_enabled(AttachmentId attachment, bool enabled);
  /// Holds pairs of an attachment from the next step on with their points where they are now, as what carries
  /// them sees it. Throws InvalidArgument for pairs that cannot (sim/model/held_places.h) and broken ones;
  /// then nothing has changed.
  void hold_pairs_here(AttachmentId attachment, std::span<const int32_t> pairs);
  /// Releases some pairs of an attachment.
  void release_pairs(AttachmentId attachment, std::span<const int32_t> pairs);
  /// Where the place of a constraint is in held_places(); null: it cannot hold what it finds.
  const HeldPlace* find_held_place(int32_t constraint) const;
  /// The same as the position of its first number there, or of those of the pairs of an attachment; -1: none.
  int64_t first_held_place(JointId joint) const;
  int64_t first_held_place(AttachmentId attachment) const;
  /// Where side a is on the carriers of side b, of all constraints that can hold what they find.
  const std::vector<double>& held_places() const {
    return state_.held_place.empty() ? model_->initial_places() : state_.held_place;
  }
  /// By pair, held or not: distance from where it is attached [m].
  std::vector<double> attachment_gaps(AttachmentId attachment) const;
  /// By pair: 1 held, 0 released, -1 broken.
  std::vector<int32_t> attachment_status(AttachmentId attachment) const;
  /// Forces [N] on the points of side a in the last step, zero for pairs that were not held; what carries
  /// them gets the opposite. After set_state, of the multipliers of the state, as joint_reaction.
  std::vector<Vec3> attachment_forces(AttachmentId attachment) const;

  /// Pairs of bodies that started within their contact distance, and the one that they have now [m].
  std::vector<std::tuple<int32_t, int32_t, double>> close_bodies() const;
  /// Numbers in State::contact_regained are below this one.
  int64_t exclusion_count() const;

  /// The contacts of the last step: who touches whom where, forces and slip. Empty before the first step,
  /// after set_state() and without contact. Groups are indices of bodies, sites those of surface_mesh().
  /// Valid until something changes.
  const std::vector<ContactForce>& contacts() const;
  /// Sum of the contact forces on a body in the last step, friction included [N].
  Vec3 contact_force(BodyId body) const;
  /// The same on each vertex of a body [N].
  std::vector<Vec3> vertex_contact_forces(BodyId body) const;
  /// Forces [N] that hold the pinned vertices of a body where they are prescribed, clamped nodes among them,
  /// in the last step and in the order of pin_targets(): against all that acts there, weight and inertia of
  /// the vertices included. Zero before the first step and after set_state().
  std::vector<Vec3> pin_forces(BodyId body);
  /// Torques [N m] that hold the frames of clamped nodes of a rod, in the order of clamp_targets().
  std::vector<Vec3> clamp_torques(BodyId body);
  /// Force [N] that holds a fixed rigid body or drives a scripted one, which have no mass, and its torque
  /// [N m] about the origin of the mesh; zero of bodies that move freely.
  Wrench holding_wrench(BodyId body);
  /// What each segment of a rod transmits in the last step, through its middle: force [N] and torque [N m] of
  /// the side behind on the side before. Damping and what pulls in the rod by itself are in it.
  std::vector<Wrench> section_wrenches(BodyId body) const;
  /// Points of the surfaces of two bodies that are nearest to each other, as they are now; of rods, of their
  /// centre lines. Distance 0 where they intersect; contact may be disabled. Throws InvalidArgument for a
  /// body with itself.
  ClosestPoints closest_points(BodyId a, BodyId b);
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
  /// [m], valid until the state changes.
  const std::vector<Vec3>& site_positions() const;

 private:
  struct Parts;

  void make_solver();
  /// Whether a joint or a pair of an attachment, by its number in the constraints, has a break force.
  bool may_break(int32_t constraint) const;
  /// Whether users may move it between steps, but for placing: no joint of rigid bodies that are not
  /// scripted.
  bool may_be_driven(int32_t constraint) const;
  void check_initial_state() const;
  /// Throws InitialIntersection where surfaces intersect or contain each other at site positions x; `when`
  /// names them: "at time 0".
  void check_clear(std::span<const Vec3> x, const std::string& when) const;
  void check_state_clear(const State& state, std::span<const Vec3> x, const std::string& when);
  /// Places by itself what is not part of a placing under way.
  void place_with(const std::function<void(Placing&)>& change);
  void require_free(BodyId body, const char* what) const;
  void check_energies();
  void check_start(PotentialBatch& batch, std::span<const Vec3> x, const std::string& owner) const;
  void check_invariance(const PotentialBatch& batch, std::span<const double> element,
                        const std::string& where) const;
  /// Takes the place of a constraint anew, with sites at x.
  void take_place(const HeldPlace& place, std::span<const Vec3> x);
  void check_joints();
  void check_actuators();
  void check_attachments();
  void check_pairs(AttachmentId attachment, std::span<const int32_t> pairs) const;
  /// After the state was replaced: sensors have nothing to tell of it.
  void forget_last_step();
  double scene_size() const;  ///< [m] diagonal of a box around all bodies
  double checked_duration(const std::string& owner, std::optional<double> duration) const;
  /// Null before the first step, after set_state() and without contact.
  const ContactReadings::Found* contact_readings() const;
  const ModelBody& rigid(BodyId body, const char* what) const;
  const ModelBody& rod(BodyId body) const;

  Scene scene_;
  Settings settings_;
  std::unique_ptr<ThreadPool> pool_;
  std::unique_ptr<PhaseTimer> timer_;
  Energies energies_;
  std::unique_ptr<const Model> model_;
  State state_, start_state_;
  SurfaceMesh surface_mesh_;
  std::vector<bool> is_filled_;  ///< by body
  std::unique_ptr<ContactPipeline> contact_;
  std::unique_ptr<SiteReadings> site_readings_;
  std::unique_ptr<ContactReadings> contact_readings_;  ///< null without contact
  std::unique_ptr<IntersectionFinder> intersections_;  ///< null without contact
  std::unique_ptr<Assembler> assembler_;
  std::unique_ptr<SelfStress> self_stress_;
  std::unique_ptr<IncrementalPotential> potential_;
  std::unique_ptr<LinearSolver> linear_solver_;
  std::vector<Vec3> step_start_;  ///< site positions that the last step started from [m]; or empty
  std::unique_ptr<Parts> parts_;  ///< of its steps
};

}  // namespace stark
