// The motion of a step: what its velocities are measured from, where it brings what is prescribed and what is
// free, and what the state has of it afterwards (step phases 1, 2 and 6). [theory eq. 9a, 9b, 26, 26a, 26c]
#pragma once

#include <algorithm>
#include <set>
#include <span>
#include <utility>
#include <vector>

#include <stark/contact/restitution.h>
#include <stark/mechanics/time_integrator.h>
#include <stark/mechanics/turning_frame.h>
#include <stark/sim/step/step_part.h>

namespace stark {

/// Whether constraints of a group are kept at or below zero: stops, slack ropes.
inline bool has_stops(const ConstraintGroup& group) {
  return std::ranges::any_of(group.joint->one_sided(), [](char one_sided) { return one_sided != 0; });
}

/// What the velocities of a step are measured from.
struct MotionReference {
  TimeStencil stencil;
  bool has_impact = false;  ///< a stop is hit, or free motion leads through something; also without a history
  Configuration place;
  std::vector<Vec3> point_velocity, body_velocity;  ///< v_bar [m/s]
  std::vector<Vec3> contact_velocity;               ///< by body: what contact and impacts have added [m/s]
  std::vector<Mat3> body_rotation_rate;             ///< [1/s]
  std::vector<Mat3> free_rotation;                  ///< where the inertia of free bodies brings them
  std::vector<Vec3> angular_momentum;               ///< theirs without what acts in the step [kg m^2/s]
  std::vector<double> joint_rate;                   ///< [m/s, rad/s]
  std::vector<TurningFrame> frames;                 ///< of what turns as a whole and is free; or empty
  std::vector<Vec3> sites;                          ///< positions of the sites at `place` [m]
  std::vector<Vec3> friction_sites;                 ///< what slip is measured from [m]
  double friction_duration = 0.0;                   ///< and over what time [s]
  // Empty without a history:
  std::vector<Vec3> before;   ///< positions of the sites at the start of the last step [m]
  double since_before = 0.0;  ///< length of that step [s]; the state has that of this one when it ends
  std::vector<Vec3> beyond;   ///< `sites` and sqrt(1 + 1/c) times their way from the start [m]; or empty
  // What energies measure rates over, which predict() sets:
  double scale = 0.0;       ///< [s]
  double flow_scale = 0.0;  ///< the same of internal variables that flow [s]
  double time = 0.0;        ///< at the end of the step [s]
  // Of such energies, empty without a history or without them: [theory eq. 26d]
  std::vector<Vec3> half_way;         ///< start of the step and half a step at its velocity [m]
  std::vector<Vec3> beyond_half_way;  ///< as far again [m]
};

/// Rigid bodies at the start of a step with restitution, and their sites as RestitutionSet::Motion has them.
struct ImpactReference {
  std::vector<Vec3> position, velocity, angular_velocity, spin;  ///< by body [m, m/s, rad/s, kg m^2/s]
  std::vector<Vec3> turned, velocities, references, lead;
};

class StepMotion : private StepPart {
 public:
  explicit StepMotion(const StepContext& context) : StepPart(context) {}

  /// Length of a step in which no scripted body turns by more than a sixteenth of a turn, and free ones not
  /// by more than their integrator stands [s].
  double longest_turning_step() const;
  Configuration start_configuration() const;
  Configuration target_configuration(double h) const;

  /// Increments of all unknowns in a step of length h in which everything goes on as it moves.
  /// [theory eq. 22a]
  std::vector<double> free_increments(double h) const;

  /// Sets what the velocities of a step of length h are measured from; `hits_stop`: what moves arrives at a
  /// stop of a coordinate in it.
  void begin(double h, bool hits_stop = false);
  const MotionReference& reference() const { return reference_; }
  /// Puts back what begin() has set before.
  void set_reference(MotionReference reference) { reference_ = std::move(reference); }
  /// Coordinates of joints that their rates are measured from, angles up to full turns [m, rad].
  std::vector<double> coordinates() const;
  /// Predictions and times of all energies, for a step of length h by the integrator.
  void predict(double h);
  /// The same with predictions for `duration`, and inertia and damping of a step of length `scale` [s].
  void predict(double h, double duration, double scale);
  /// Gives a batch the positions that it measures velocities and rates from.
  template <typename Batch>
  void set_previous(Batch& batch) const {
    if (reference_.sites.empty()) return;  // before the first step
    if (flows(batch)) {
      batch.set_previous(reference_.half_way);
      batch.set_beyond(reference_.beyond_half_way);
      return;
    }
    batch.set_previous(reference_.sites);
    if (!reference_.beyond.empty()) batch.set_beyond(reference_.beyond);
  }
  /// Gives a batch the times of the step.
  template <typename Batch>
  void set_clock(Batch& batch) const {
    if (reference_.sites.empty()) return;
    batch.set_time(flows(batch) ? reference_.flow_scale : reference_.scale, reference_.time);
  }
  /// Lets internal variables that flow at a rate do so for the first half of a step of length h.
  void begin_flow(double h);
  /// What restitution needs of a step of length h, what it remembers and keeps.
  RestitutionSet::Motion restitution_motion(double h);
  /// How rigid bodies have moved in it; call it after commit().
  RestitutionSet::End restitution_end(double h) const;
  RestitutionMemory restitution_memory() const;
  void remember_impacts(RestitutionMemory memory);

  /// Takes over what the potential has at the end of a step of length h.
  void commit(double h);

  /// Angular momentum of body b about its centre of mass [kg m^2/s].
  Vec3 spin(size_t b) const;
  /// Velocity of a point of body b given in its principal frame, relative to the centre of mass [m/s].
  Vec3 turning_velocity(int32_t b, const Vec3& local) const;
  /// By site [m/s].
  std::vector<Vec3> site_velocities() const;
  /// Sites after a step of length h in which nothing pushes [m].
  std::vector<Vec3> free_motion(double h) const;

 private:
  /// Whether internal variables of the batch flow by halves of the step.
  template <typename Batch>
  bool flows(const Batch& batch) const {
    return !reference_.half_way.empty() && potential_of(batch).flows_at_a_rate();
  }
  /// What the step of length h that starts from the state has of the integrator.
  TimeStencil choose_stencil(double h, bool hits_stop);
  /// Share of the increments by contact in the last step that other forces balanced, the least of all bodies
  /// that touch, by pairs of them (group_code()); 0 where nothing pushed.
  double lasting_contact(const std::set<int64_t>& touching) const;
  /// Rotations and angular momenta of free bodies at the end of a step of length h if nothing acted in it.
  void set_free_rotations(double h);
  /// Angular impulse of a step over its scale [N m] on each body with a free rotation; call it before
  /// anything of the step is taken over.
  std::vector<Vec3> torques();
  /// What free bodies of points turn with in a step of length h, and where inertia brings their points.
  void set_frames(double h);
  /// Their velocities at the end of the step, from reference() and the state.
  void commit_frames(double h);
  /// Takes over the rotation that body b has at the end of a step of length h.
  void commit_rotation(int32_t b, const Vec3& torque, double h);
  /// Impulses on the free blocks in the step that ends now [N s, N m s].
  struct Impulses {
    std::vector<Vec3> contact;      ///< with friction, and with `hit`
    std::vector<Vec3> hit;          ///< of all that is held in a step with an impact; else empty
    std::vector<Vec3> restitution;  ///< empty without contact
  };
  Impulses contact_impulses();
  std::vector<Vec3> impulses_of(std::span<const PotentialBatch* const> batches) const;
  /// Keeps the state that a step of length h has started from, for the next one.
  void remember_state(double h);
  struct Motions {
    std::vector<Vec3> point_velocity, body_velocity;  ///< [m/s]
    std::vector<Vec3> spin;                           ///< angular momenta of the bodies [kg m^2/s]
  };
  Motions motions() const;
  /// Keeps what the velocities that were there `before` the step have gained, and how.
  void remember_increments(const Motions& before, const Impulses& impulses, double h);
  /// Takes a part of the impulses of an impact on what is held out of those of contact [N s, N m s].
  void drop_impact(std::span<const Vec3> hit, double part);

  /// Angular velocity of body b with rotation R and the angular momentum that it has started the step with.
  Vec3 unpushed_angular_velocity(size_t b, const Mat3& R) const;
  /// value(body, place in its principal frame) of all sites of rigid bodies, zero of others.
  template <typename Value>
  std::vector<Vec3> by_rigid_site(const Value& value) const;

  MotionReference reference_;
  ImpactReference impact_;
  std::vector<double> scratch_gradient_;
};

}  // namespace stark
