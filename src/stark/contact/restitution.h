// Restitution of rigid bodies: what an impact gives back of the speed with which two bodies met (step
// phases 2 and 6).
//
// The layer of contact takes up an impact, in one step or in many, and what it gives back by itself is a
// matter of the steps. With a coefficient e an impact has two phases instead. While the bodies approach, the
// contact forces push as always, and their impulse P, their work W and the speed V of approach are summed up.
// In the step after that the layer has done its work: its stiffness falls to what carries the weight, from
// where it recovers, and a force along the mean contact force of the impact brings the relative speed there
// to e V. It is limited by e times the impulse and by e^2 times the energy of the approach, and it may take
// back no more than P. [theory eq. 19b]
#pragma once

#include <array>
#include <map>
#include <memory>
#include <span>
#include <utility>
#include <vector>

#include <stark/contact/contact_law.h>
#include <stark/contact/contact_set.h>
#include <stark/mechanics/potential_batch.h>

namespace stark {

/// Impacts under way and what follows them, by pair of bodies. Part of the State; sorted, without doubles.
struct RestitutionMemory {
  std::vector<int64_t> bodies;    ///< group_code()
  std::vector<double> speed;      ///< V [m/s], 0 without an impact
  std::vector<double> impulse;    ///< P [N s]
  std::vector<double> work;       ///< W [J]
  std::vector<double> load;       ///< force that lasts [N]
  std::vector<double> stiffness;  ///< of the layer, over its own
  std::vector<double> due;        ///< 1: the next step gives back
  std::vector<double> rate;       ///< of approach at the end of the step, negative [m/s]
  std::vector<Vec3> normal;       ///< mean direction of the contact forces on the first body
  std::vector<Vec3> moment;       ///< of a unit force on it about the origin of the world [m]
};

/// What the scene says of it, by group.
struct RestitutionTable {
  std::map<int64_t, double> coefficient;      ///< by group_code()
  std::vector<Vec3> gravity;                  ///< [m/s^2], zero of what does not fall
  std::vector<std::array<int32_t, 3>> frame;  ///< sites of a rigid group that span its motion
};

class RestitutionSet {
 public:
  /// potential: see compile_contact_potentials(); null without coefficients.
  RestitutionSet(RestitutionTable table, std::shared_ptr<const Potential> potential);

  bool empty() const { return table_.coefficient.empty(); }

  /// A step, by site of the rigid bodies. Where nothing pushes they turn by it to `turned`.
  struct Motion {
    std::span<const Vec3> turned;      ///< start, with the rotation that free motion ends with [m]
    std::span<const Vec3> velocities;  ///< there, before anything has pushed [m/s]
    std::span<const Vec3> references;  ///< from where velocities are displacements [m]
    std::span<const Vec3> lead;        ///< of the centres of mass there over the start [m]
    double duration = 0.0;             ///< over which velocities are displacements [s]
    double step = 0.0;                 ///< [s]
    double weight = 1.0;               ///< of contact beside other forces: see TimeStencil
    /// Part of g h by which free fall is late: 1 of implicit Euler, 0 of what is exact.
    double delay = 0.0;
  };
  /// Starts a step at site positions x. Empty motions, of steps without inertia, forget all impacts.
  void begin_step(RestitutionMemory memory, std::span<const Vec3> x, const Motion& motion);

  /// The end of a step, by site of the rigid bodies and at the place where it ends.
  struct End {
    std::vector<Vec3> before;  ///< velocities with the momentum at the start of the step [m/s]
    std::vector<Vec3> after;   ///< at its end [m/s]
    std::vector<Vec3> way;     ///< along the mean of both [m]
  };

  /// Layers that have taken up an impact.
  std::map<int64_t, SpentLayer> spent() const;

  /// Contacts at the start of the step, with their forces on sides A [N] and what they store [J]: where what
  /// is given back acts. What they can still push apart is the most that is taken back besides the speed that
  /// was too large before the step.
  void set_contacts(const std::vector<Contact>& contacts, std::span<const Vec3> forces,
                    std::span<const double> energies);
  /// Those of pairs that give back, with the forces of that on their sides A at site positions x [N].
  std::vector<std::pair<Contact, Vec3>> given_back(std::span<const Vec3> x) const;
  /// A force along the line of action of an impact: normal * force on the first body of a pair [N].
  struct LineForce {
    int64_t bodies = 0;
    Vec3 normal;
    double force = 0.0;
    Vec3 at;  ///< where the line is nearest to the origin [m]
  };
  /// Of pairs that give back and were out of reach at the start of the step, so that they have no contact.
  std::vector<LineForce> given_back_beyond(std::span<const Vec3> x) const;
  /// Energy that has been given back in the step that ended at x: forces over the mean motion [J].
  double work(std::span<const Vec3> x) const;

  std::vector<const PotentialBatch*> batches() const;
  void remember(std::span<const Vec3> x);
  EnergyDifference energy_difference(std::span<const Vec3> x) const;

  /// Takes the end of the step at site positions x, with contacts and their forces on sides A [N].
  RestitutionMemory end_step(const std::vector<Contact>& contacts, std::span<const Vec3> forces,
                             std::span<const Vec3> x, const End& end) const;

 private:
  /// An impact, or what is left of one, of two bodies: a row of the memory.
  struct Impact {
    double speed = 0.0, impulse = 0.0, work = 0.0, load = 0.0, stiffness = 1.0, due = 0.0, rate = 0.0;
    Vec3 normal, moment;
    double mass = 0.0;  ///< that the approach has brought to rest: its impulse over its change of speed [kg]
  };
  /// Contact between two bodies at the end of a step.
  struct Sum {
    double force = 0.0;                       ///< [N]
    double rate_start = 0.0, rate_end = 0.0;  ///< relative speed along it, negative where they approach [m/s]
    double way = 0.0;                         ///< relative motion along it [m]
    Vec3 normal, moment;
  };
  /// Force of a pair that gives back [N], and the mean of the relative speeds before and after [m/s].
  struct Return {
    int64_t bodies = 0;
    double force = 0.0, mean_rate = 0.0;
  };
  std::vector<Return> returns(std::span<const Vec3> x) const;
  /// Points of application of a unit force in a frame that has its direction and its moment.
  std::array<Vec3, 3> shares(int32_t group, const Vec3& normal, const Vec3& moment,
                             std::span<const Vec3> x) const;
  /// Relative motion along a force of vectors by site.
  double along(int64_t bodies, const Impact& impact, std::span<const Vec3> x,
               std::span<const Vec3> vectors) const;
  /// Acceleration with which gravity brings the bodies together along the normal [m/s^2].
  double fall(int64_t bodies, const Vec3& normal) const;
  std::map<int64_t, Sum> sums(const std::vector<Contact>& contacts, std::span<const Vec3> forces,
                              std::span<const Vec3> x, const End& end) const;
  Impact next(int64_t bodies, Impact impact, Sum sum) const;
  void set_element(int64_t element, int64_t bodies, const Impact& impact);
  /// Bounds what a pair takes back, whose contacts store an energy [J].
  void bound_pull(int64_t element, const Impact& impact, double stored);

  RestitutionTable table_;
  std::vector<std::pair<Contact, Vec3>> contacts_;  ///< of pairs that give back, with shares of the force
  std::vector<PotentialBatch> batch_;               ///< one, or none without coefficients
  std::map<int64_t, Impact> impacts_;               ///< at the start of the step
  std::vector<Vec3> references_;
  Motion motion_;
  std::vector<double> remembered_;
};

}  // namespace stark
