// Placing: bodies that the user puts elsewhere or gives other velocities between two steps. What was moved
// starts anew: no friction, no impacts, no forces of contact and joints, no history of the integrator; the
// rest goes on. Phase: between steps.
#pragma once

#include <functional>
#include <optional>
#include <set>
#include <span>
#include <string>
#include <vector>

#include <stark/sim/step/step_joints.h>
#include <stark/sim/step/step_ledger.h>

namespace stark {

/// What was placed between two steps.
struct Placed {
  std::vector<int32_t> bodies{};  ///< that were put elsewhere or got other velocities, by number; sorted
  double energy = 0.0;            ///< kinetic, elastic and potential energy that it gave them [J]
};

class Placing : private StepPart {
 public:
  Placing(const StepContext& context, StepMotion& motion, StepJoints& joints, StepLedger& ledger,
          const SurfaceMesh& mesh)
      : StepPart(context), motion_(motion), joints_(joints), ledger_(ledger), surface_mesh_(mesh) {}

  /// From begin() to end() or cancel() bodies are placed together.
  void begin();
  bool is_open() const { return is_open_; }
  /// Throws while bodies are placed; `what` needs all of them.
  void require_closed(const char* what) const;
  /// Throws where constraints do not hold or surfaces meet, with `check_clear` for the latter; then the state
  /// is as it was at begin(). False where nothing was placed: what is put where it is goes on as it was.
  bool end(const std::function<void(std::span<const Vec3> x)>& check_clear);
  void cancel();
  /// Since the last step.
  const Placed& placed() const { return placed_; }
  void forget() { placed_ = {}; }
  /// Stored energy that a new value of an energy of the scene has added.
  void add_energy(double energy) {
    placed_.energy += energy;
    stored_before_ += energy;
  }
  /// The worst of some constraints that act, by number, where bodies are now: "actuator 'stop' is off by
  /// 0.5 rad"; empty where all hold.
  std::string misfit_text(const std::function<bool(int32_t)>& some);

  /// Pose of the body frame of a free rigid body: centre of mass [m], rotation from the principal axes.
  void put_rigid(int32_t body, const Vec3& centre, const Mat3& rotation);
  /// Embedded vertices follow the others, whatever is given for them.
  void put_points(int32_t body, std::span<const Vec3> positions);
  /// Moves bodies of all kinds as one, p -> rotation p + shift, frames of rods and fibres included.
  /// Velocities turn along; what is pinned rests where it comes to.
  void put_together(const std::set<int32_t>& bodies, const Mat3& rotation, const Vec3& shift);
  /// Velocity of the centre of mass [m/s], angular velocity [rad/s].
  void push_rigid(int32_t body, const Vec3& velocity, const Vec3& angular_velocity);
  void push_points(int32_t body, std::span<const Vec3> velocities);
  /// Coordinates of a joint [m, rad]: what hangs on one of its sides moves as one.
  void put_joint(int32_t joint, std::span<const double> coordinates);
  /// Rates of its coordinates [m/s, rad/s].
  void push_joint(int32_t joint, std::span<const double> rates);

 private:
  /// A rigid motion: p -> rotation (p - pivot) + pivot + shift.
  struct Transform {
    Mat3 rotation = Mat3::identity();
    Vec3 pivot{}, shift{};
    Vec3 operator()(const Vec3& p) const { return rotation * (p - pivot) + pivot + shift; }
  };
  /// Velocity of the pivot [m/s] and angular velocity [rad/s].
  struct Twist {
    Vec3 linear{}, angular{};
  };
  /// What hangs on a side of a joint.
  struct Branch {
    std::set<int32_t> bodies{};
    bool is_b = true;  ///< of side b
  };

  // Of bodies (placing.cpp).
  /// Sets embedded vertices to where the others bring them.
  void follow();
  bool is_there(const ModelBody& body, std::span<const Vec3> positions) const;
  void require_matching(int32_t body, size_t rows, const char* what) const;
  std::pair<int32_t, int32_t> rigid_range(int32_t body) const;  ///< first and count in the body arrays
  std::vector<int32_t> fibre_frames(int32_t body) const;
  std::set<int32_t> changed() const;
  void check_contacts(const std::set<int32_t>& moved);
  void drop_contact_memory(const std::set<int32_t>& moved);
  void restart_history(int32_t body);
  void shift_history(int32_t body);

  // Of joints (placing_joints.cpp).
  const std::string& joint_name(int32_t joint) const;
  bool touches(int32_t constraint, const std::set<int32_t>& bodies) const;
  void check_constraints(const std::set<int32_t>& moved);
  void restart_constraints(const std::set<int32_t>& moved, const std::set<int32_t>& changed);
  bool is_held(int32_t body) const;  ///< by the world or the program, in part at least
  std::optional<std::set<int32_t>> hanging(int32_t joint, const FrameDescription& from,
                                           const FrameDescription& other) const;
  Branch branch(int32_t joint) const;
  std::vector<double> values(int32_t joint, std::span<const Vec3> x) const;
  /// In which the fastest of some bodies hardly moves, for differences [s].
  double short_time(const std::set<int32_t>& bodies) const;
  std::vector<double> rates(int32_t joint) const;
  std::vector<Vec3> sites(double time_ago = 0.0) const;
  Vec3 pivot(int32_t joint, std::span<const Vec3> x) const;
  void move_sites(int32_t joint, bool is_b, const Transform& transform, std::vector<Vec3>& x) const;
  std::vector<std::array<double, 6>> jacobian(int32_t joint, bool is_b, const Vec3& pivot,
                                              std::span<const Vec3> x) const;
  std::vector<double> error(int32_t joint, std::span<const Vec3> x, std::span<const double> target) const;
  std::vector<Transform> way_to(int32_t joint, bool is_b, std::span<const double> target) const;
  void move(const std::set<int32_t>& bodies, const Transform& transform);
  void turn_velocities(const std::set<int32_t>& bodies, const Transform& transform,
                       const FrameDescription& about);
  void add_twist(const std::set<int32_t>& bodies, const Vec3& pivot, const Twist& twist);
  void set_rates(int32_t joint, const Branch& branch, std::span<const double> wanted);

  StepMotion& motion_;
  StepJoints& joints_;
  StepLedger& ledger_;
  const SurfaceMesh& surface_mesh_;
  bool is_open_ = false;
  State before_;                      ///< at begin()
  double stored_before_ = 0.0;        ///< [J]
  std::set<int32_t> moved_, pushed_;  ///< bodies, since begin()
  Placed placed_;
};

}  // namespace stark
