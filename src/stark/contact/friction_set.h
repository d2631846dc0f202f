// Friction of the contacts of a configuration. Normal force, tangent plane and closest points of a pair are
// frozen while energies are minimised and refreshed in between until they agree with the result
// (step phase 2). Sticking pairs are held by bristles that keep their deflection from step to step.
// [theory eq. 19 to 20a]
#pragma once

#include <functional>
#include <map>
#include <optional>
#include <set>
#include <utility>
#include <vector>

#include <stark/contact/contact_set.h>
#include <stark/contact/friction_coefficient.h>
#include <stark/contact/friction_limits.h>
#include <stark/contact/friction_memory.h>
#include <stark/contact/friction_stencil.h>
#include <stark/contact/surface_directions.h>
#include <stark/contact/surface_motion.h>
#include <stark/mechanics/active_set.h>

namespace stark {

/// Coulomb's coefficients of a pair of groups.
using FrictionTable = std::function<FrictionCoefficient(int32_t group_a, int32_t group_b)>;

/// Friction of 2 to 6 points.
struct FrictionPotentials {
  static constexpr int kCounts = kFrictionPoints - 1;
  std::array<std::shared_ptr<const Potential>, kCounts> isotropic;
  std::array<std::shared_ptr<const Potential>, kCounts> anisotropic{};  ///< null where no pair asks for it
};

/// How displacements of a step are measured: from `positions` [m], times `scale`. The integrator's reference
/// makes them its velocity times the step, and gives contact a weight beside other forces.
struct DisplacementReference {
  std::vector<Vec3> positions;
  double scale = 1.0;
  double weight = 1.0;    ///< of what the batches have
  double duration = 0.0;  ///< of the displacements, before the factor [s]; of moving surfaces
};

class FrictionSet {
 public:
  /// stick_displacement: deflection of the bristles at which a pair begins to slide [m]; where friction
  /// depends on the direction, in that of the larger coefficient.
  FrictionSet(const FrictionPotentials& potentials, double stick_displacement, ThreadPool& pool,
              SurfaceDirections directions = {});

  /// Sites whose bodies are rigid, true by site; none by default.
  void set_rigid_sites(std::vector<bool> rigid) { rigid_sites_ = std::move(rigid); }

  /// Sites where friction of corners of flat faces acts, and the flat faces by triangle; none by default.
  void set_levers(std::vector<LeverSite> sites, std::vector<int32_t> patch) {
    lever_sites_ = std::move(sites);
    patch_ = std::move(patch);
  }

  /// Surfaces that move along themselves; none by default.
  void set_moving_surfaces(MovingSurfaces surfaces) { moving_ = std::move(surfaces); }
  /// Their velocities [m/s] and spins [rad/s] in the coming step.
  void set_surface_motions(std::span<const Vec3> velocities, std::span<const Vec3> spins) {
    moving_.set(velocities, spins);
  }

  /// Starts a step at site positions x with what is remembered of the last one.
  void begin_step(const SurfaceMesh& mesh, FrictionMemory memory, std::span<const Vec3> x,
                  DisplacementReference reference);

  /// Freezes friction at the contacts with their forces on sides A, at site positions x. Returns the largest
  /// change of a friction limit mu lambda [N]; 0 when all are within 0.1 % of the largest and 1 % of the
  /// largest between the same bodies. After the first call in a step, only what end_step() remembers changes
  /// then: the solution is the one with the friction that it was found with. The first call returns the
  /// largest limit, and takes the normal forces of pairs in the memory from there. From the third one on,
  /// pairs keep their tangent planes and closest points: near an impact, turning planes keep friction from
  /// settling.
  double reset(const std::vector<Contact>& contacts, std::span<const Vec3> forces,
               const FrictionTable& coefficient, std::span<const Vec3> x);
  /// Takes all of it anew between two calls of reset(), however little it changes, or that of bodies that had
  /// friction at the start of the step. Where bodies hit each other, forces on the first part of the way to
  /// the solution say nothing of those at the end.
  void renew(const std::vector<Contact>& contacts, std::span<const Vec3> forces,
             const FrictionTable& coefficient, std::span<const Vec3> x, Lagged lagged);

  /// Keeps what was frozen before the last reset.
  void keep() { kept_ = previous_; }
  /// Freezes friction as it was kept.
  void restore();

  /// Frozen limits and those by these contacts and forces.
  LimitComparison residual(const std::vector<Contact>& contacts, std::span<const Vec3> forces,
                           const FrictionTable& coefficient) const;

  /// What to remember of a step that ended at x.
  FrictionMemory end_step(std::span<const Vec3> x) const;

  std::vector<const PotentialBatch*> batches() const { return non_empty(batches_); }
  /// Convex parabolas with the gradients of the energies at x. Their curvatures follow from what is known of
  /// the forces, which goes on from one iterate to the next: those of the energies, or larger ones where
  /// Newton's method would overshoot. [theory eq. 20d]
  std::vector<const PotentialBatch*> models(std::span<const Vec3> x);
  struct PairMotion {
    Vec3 force;  ///< on the first primitive [N]
    /// Of the material of the first primitive against the second since the reference, where friction acts
    /// [m].
    Vec3 motion;
    Contact contact;  ///< as friction was frozen
    Vec3 normal;      ///< unit, to side A
    FrictionStencil stencil;
  };
  /// Friction of the pairs at site positions x.
  std::map<PairKey, PairMotion> motions(std::span<const Vec3> x) const;
  bool empty() const { return pairs_.empty(); }
  /// Energy in the bristles as they were bent at the start of the step, with the limits of now, above that of
  /// straight ones [J]. By convexity the work that friction gives back in the step is no more.
  double energy_at_start() const;
  /// Work that the drives of moving surfaces do against friction in the step that ends at x [J].
  double surface_work(std::span<const Vec3> x) const;
  /// Displacement of the material of side A of a contact against that of side B, in the plane of a unit
  /// normal, that the motion of the bodies does not have, at closest points that are shifted [m].
  Vec3 drift(const Contact& contact, const Vec3& normal, std::span<const Vec3> x,
             const Vec3& shift = {}) const;

  /// Energies at x are compared with those at the last remember(), element by element.
  void remember(std::span<const Vec3> x);
  EnergyDifference energy_difference(std::span<const Vec3> x) const;

 private:
  struct Pair {
    Contact contact;
    FrictionStencil stencil;
    Vec3 normal;         ///< unit, to side A
    Vec3 deflection;     ///< at the start of the step, of side A against side B [m]
    double force = 0.0;  ///< normal force [N]
    double limit = 0.0;  ///< mu lambda [N]
    bool slides = false;
    bool is_anisotropic = false;
    Vec3 along, across;  ///< anisotropic: unit tangents times their shares of the larger coefficient
    Vec3 drift{};        ///< see drift()
    Vec3 dual{};         ///< against the force, over the limit; in the metric of the pair at most 1
    std::optional<Vec3> modelled{};  ///< deflection at the last iterate with a model, over the scale [m]
  };

  struct Fields {  ///< of a batch, by number; -1: it has none
    Fields(const PotentialBatch& batch, bool is_anisotropic);
    int limit, deflection, first, second, facing;
    int slope, pull, way, pull_at_iterate, way_at_iterate;
    std::array<int, kFrictionPoints> weights{}, slopes{};
  };

  Pair make_pair(const Contact& contact, const FrictionCoefficient& mu, const Vec3& force,
                 std::span<const Vec3> x, PressedAreas& areas) const;
  std::vector<Pair> make_pairs(const std::vector<Contact>& contacts, std::span<const Vec3> forces,
                               const FrictionTable& coefficient, std::span<const Vec3> x) const;
  static int64_t bodies_of(const Pair& pair);
  /// Entry of the memory whose bristles a pair goes on with, -1 if there is none: its own, or that of the
  /// same point on a triangle beside, where the point has slid across an edge or a valley has split its
  /// contact.
  int64_t find_bristles(const Contact& contact, std::span<const Vec3> x) const;
  void set_axes(const FrictionCoefficient& mu, std::span<const Vec3> x, Pair& pair) const;
  /// Length of a deflection in the metric of the pair: sliding begins at the stick displacement [m].
  static double measure(const Pair& pair, const Vec3& deflection);
  Vec3 limited(const Pair& pair, Vec3 deflection) const;
  const Pair* find(const PairKey& key) const;
  Vec3 deflection(const Pair& pair, std::span<const Vec3> x) const;
  /// By which the material of a moving surface turns more than what spin() takes for it [rad].
  double surface_turn(const Pair& pair, std::span<const Vec3> x) const;
  /// On side A [N].
  Vec3 force(const Pair& pair, std::span<const Vec3> x) const;
  /// f0'(y) / y of a deflection of measure y [1/m].
  double slope_at(double y) const;
  /// Derivative of phi(y) = 1 / slope_at(y).
  double phi_prime(double y) const;
  /// M u, with M the matrix of the metric, of vectors in the tangent plane.
  static Vec3 in_metric(const Pair& pair, const Vec3& u);
  /// Takes the dual force on to an iterate with this deflection.
  void update_dual(const Vec3& u, Pair& pair) const;
  /// Of the element of a model, at site positions x.
  void set_model(size_t batch, int64_t element, std::span<const Vec3> x);
  /// What LimitComparison sees of pairs.
  static std::vector<FrictionLimit> limits(const std::vector<Pair>& pairs);
  /// Freezes the pairs of the first reset of a step. Returns their largest limit [N].
  double start(std::vector<Pair> pairs);
  void freeze(std::vector<Pair> pairs);
  static std::vector<const PotentialBatch*> non_empty(const std::vector<PotentialBatch>& batches);
  void fill(std::vector<PotentialBatch>& batches) const;
  void set_fields(const Pair& pair, const Fields& fields, int64_t e, PotentialBatch& batch) const;
  std::vector<double> energies(std::span<const Vec3> x) const;

  double stick_displacement_;  ///< [m]
  ThreadPool& pool_;
  SurfaceDirections directions_;
  MovingSurfaces moving_;
  std::vector<bool> rigid_sites_;
  std::vector<LeverSite> lever_sites_;
  std::vector<int32_t> patch_;
  FrictionCarriers carriers_;  ///< of the mesh
  const SurfaceMesh* mesh_ = nullptr;
  FrictionMemory memory_;
  DisplacementReference reference_;
  std::vector<Vec3> x_start_;
  std::vector<Pair> pairs_;     ///< sorted by key
  std::vector<Pair> previous_;  ///< before the last reset
  std::vector<Pair> kept_;
  std::optional<std::vector<Pair>> next_start_;  ///< what is remembered in place of pairs_
  std::set<int64_t> touching_;                   ///< bodies that had friction at the start
  LeverArms arms_at_start_;                      ///< of the step
  int resets_ = 0;                               ///< in this step
  RefreshShares shares_;
  std::vector<PotentialBatch> batches_;  ///< of 2 to 6 points, then the anisotropic ones if there are any
  std::vector<PotentialBatch> models_;
  std::vector<Fields> fields_;                ///< of each batch and its model
  std::vector<std::vector<size_t>> members_;  ///< pairs of their elements
  std::vector<double> remembered_;
};

}  // namespace stark
