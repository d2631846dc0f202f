// Contact of all kinds of bodies in one pipeline: candidates with a motion budget, active contacts, barrier,
// friction, certified step bounds (step phases 2, 4b and 4h). It sees sites only, never bodies.
#pragma once

#include <limits>
#include <memory>
#include <set>

#include <stark/base/timer.h>
#include <stark/collision/max_safe_step.h>
#include <stark/contact/candidate_search.h>
#include <stark/contact/closest_features.h>
#include <stark/contact/contact_law.h>
#include <stark/contact/contact_settings.h>
#include <stark/contact/friction_set.h>
#include <stark/contact/held_positions.h>
#include <stark/contact/restitution.h>
#include <stark/mechanics/active_set.h>

namespace stark {

/// Surfaces of a scene: vertex ids are site ids, groups are bodies.
struct ContactSurfaces {
  SurfaceMesh mesh;
  PairFilter filter;
  std::vector<double> group_distance;  ///< contact distance per group [m]
  std::vector<Vec3> rest_positions;    ///< by site [m]; sets the edges' rest lengths
  FrictionTable friction;
  std::vector<TangentComponents> directions;  ///< by triangle; none where no surface has a direction
  std::vector<int32_t> face;                  ///< by triangle, see ContactGeometry; none: each is a face
  std::vector<BodyStiffness> stiffness{};     ///< by group; none: 1 Pa for all
  std::vector<double> core{};                 ///< by group, see ContactGeometry [m]; none: 0 for all
  std::vector<int32_t> patch{};               ///< by triangle, see AreaWeights; none: each is a patch
  std::vector<LeverSite> levers{};            ///< of flat faces of rigid bodies
  std::vector<uint8_t> is_sheet{};            ///< by group, see AreaWeights
  RestitutionTable restitution{};
  std::vector<MovingSurface> moving{};
};

struct ContactPotentials {
  std::array<std::shared_ptr<const Potential>, kStencilKindCount> barriers;
  FrictionPotentials friction;
  std::shared_ptr<const Potential> restitution{};  ///< null where no pair asks for it
};

/// One barrier per StencilKind and friction of 2, 3 and 4 points, compiled for the back end; that of friction
/// which depends on the direction, and restitution, only where they are asked for.
ContactPotentials compile_contact_potentials(symbolic::Backend backend, bool anisotropic,
                                             bool restitution = false);

/// A contact with the forces and the motion of the last step.
struct ContactForce {
  Contact contact;
  Vec3 point_a, point_b;  ///< closest points [m]
  Vec3 normal_force;      ///< on side A [N]
  Vec3 friction;          ///< on side A [N]
  Vec3 slip;              ///< tangential velocity of the material of side A against that of side B [m/s]
  FrictionStencil friction_at{};  ///< without points: at the closest ones on both sides
  Vec3 friction_point{};          ///< on side A [m]
};

/// Surfaces within their contact distances: the smallest distance [m], infinity without any; and the two
/// bodies that have come closest for their contact distances.
struct Nearness {
  double distance = std::numeric_limits<double>::infinity();
  int32_t group_a = -1, group_b = -1;
  double nearest = std::numeric_limits<double>::infinity();  ///< of the two [m]
  /// That settings ask of them, whatever a step may use: a start below it, or an impact, can lower that [m].
  double least = 1.0;
};

/// What contact remembers from one step to the next.
struct ContactMemory {
  FrictionMemory friction;
  LoadMemory load;
  CloseBodies close{};
  RestitutionMemory restitution{};
};

class ContactPipeline final : public ActiveSet {
 public:
  ContactPipeline(ContactSurfaces surfaces, const ContactPotentials& potentials,
                  const ContactSettings& settings, double stick_displacement, const KinematicMap& map,
                  ThreadPool& pool, PhaseTimer& timer);

  /// Velocities of a step of length `step` [s]: displacements of the sites from `positions` [m] over
  /// `duration` [s].
  struct VelocityReference {
    std::span<const Vec3> positions;
    double duration = 0.0;
    double step = 0.0;
    double weight = 1.0;  ///< of contact beside other forces: see TimeStencil
    RestitutionSet::Motion motion{};
    /// Of the moving surfaces [m/s, rad/s].
    std::span<const Vec3> surface_velocity{}, surface_spin{};
  };
  /// Freezes areas and friction for a step that starts at site positions x.
  void begin_step(const SitePositions& x, const VelocityReference& reference, ContactMemory memory);
  /// Takes the end of a step at site positions x: contacts are those there. duration: see ContactLaw;
  /// motion: where has_restitution().
  ContactMemory end_step(const SitePositions& x, double duration = 1.0,
                         const RestitutionSet::End& motion = {});
  bool has_restitution() const { return !restitution_.empty(); }

  /// Pairs of bodies that are within their contact distance at x, with the gaps between them; of a body with
  /// itself, those of parts that are farther apart in its rest shape.
  CloseBodies find_close_bodies(std::span<const Vec3> x);

  /// Factors of the barriers for another attempt at a step, after one that failed at x.
  /// kinetic: energy of what moves [J], which bounds what this adds to that of contact.
  LoadMemory raised_load(std::span<const Vec3> x, std::span<const Vec3> start, const LoadMemory& before,
                         double kinetic);
  /// Lets contact give way in this step, see ContactRelief; most: what that may add to the energy at its
  /// start, where the last update() was [J].
  void allow_relief(double most);
  /// What it has added [J].
  double relief_energy() const { return law_.relief().added() / weight_; }
  bool relieve(const SitePositions& x) override;
  /// Largest difference between a friction limit that the step was solved with and mu times the normal force
  /// at its end [N].
  double friction_residual() const { return friction_residual_; }
  /// Limits, of all or between two bodies, that had not settled when contact.friction_updates were over.
  std::optional<LimitChange> unsettled_friction() const { return unsettled_friction_; }

  void update(const SitePositions& x) override;
  /// The same, where the last update() was not at x.
  void settle(const SitePositions& x) {
    if (!x_active_.are(x, pool_)) update(x);
  }
  std::vector<const PotentialBatch*> batches(Curvature curvature) override;
  /// Factor of the energies of batches(), 1 but with BDF2; forces and energies reported are without it.
  double weight() const { return weight_; }
  double max_step(std::span<const Vec3> x0, std::span<const Vec3> x1) override;
  /// Whether no two primitives meet on the straight way of all sites from x0 to x1.
  bool is_clear(std::span<const Vec3> x0, std::span<const Vec3> x1);
  EnergyDifference energy_difference(const SitePositions& x) override;
  double refresh_lagged(const SitePositions& x) override;
  void refresh_early(const SitePositions& x, Lagged lagged) override;
  void keep_lagged() override { friction_.keep(); }
  void restore_lagged() override {
    ++revision_;
    friction_.restore();
    forget_sets();
  }

  const std::vector<Contact>& contacts() const { return active_.contacts(); }
  const ContactSet& active_set() const { return active_; }
  const SurfaceMesh& mesh() const { return search_.mesh(); }
  /// Names of contacts of points and the law with the areas of this step.
  std::span<const PairKey> names() const { return names_; }
  const ContactLaw& law() const { return law_; }
  const PairFilter& filter() const { return search_.filter(); }
  /// Other pairs that may touch, from the next begin_step() on.
  void set_filter(PairFilter filter);
  const ContactCounters& counters() const { return search_.counters(); }
  /// Another number, above 0, whenever what contact_forces() tells of may have changed.
  uint64_t revision() const { return revision_; }
  /// The active contacts at x, where the last update() was.
  std::vector<ContactForce> contact_forces(std::span<const Vec3> x) const;
  /// Barrier energy of the active contacts [J].
  double energy() const;
  /// See FrictionSet.
  double bristle_energy_at_start() const { return friction_.energy_at_start(); }
  double surface_work(std::span<const Vec3> x) const { return friction_.surface_work(x); }
  std::vector<const PotentialBatch*> friction_batches() const { return friction_.batches(); }
  /// Whether the least distance is a bound from the next begin_step() on, or motions may take nine tenths of
  /// any gap. It always is where a body has a core.
  void set_bound(bool is_bound) { is_bound_ = is_bound || !geometry_.group_core.empty(); }
  /// Energy that restitution has given back in the step that ended at x [J].
  double restitution_work(std::span<const Vec3> x) const { return restitution_.work(x); }
  std::vector<const PotentialBatch*> restitution_batches() const { return restitution_.batches(); }
  /// How near surfaces are at x. The last update() was at x.
  Nearness nearness(const SitePositions& x);
  /// Contacts of all pairs of primitives within the contact distances of their bodies with sites at x,
  /// without their stiffness; the active ones stay as they are. Valid until the next call.
  const std::vector<Contact>& find_contacts_at(const SitePositions& x);
  /// What a motion from x0 to x1 does to contact.
  struct Approach {
    bool hits = false;  ///< whether it leads through something
    /// Motion along the normal of pairs of primitives that are in contact at x0 or x1, over their contact
    /// distance.
    double largest = 0.0;
    std::set<int64_t> before;  ///< bodies in contact at x0: group_code()
    std::set<int64_t> after;   ///< at x1, with the two that hit each other first
  };
  Approach approach(std::span<const Vec3> x0, std::span<const Vec3> x1);
  /// Pair of primitives that limited the last max_step().
  const CcdReport& limiting_pair() const { return ccd_report_; }

 private:
  void forget_sets() { is_active_ = is_trial_ = is_near_ = is_found_ = false; }

  /// Largest safe fraction of the way from x0 to x1.
  double safe_fraction(std::span<const Vec3> x0, std::span<const Vec3> x1, const Separations& separations);
  void set_close_bodies(CloseBodies close);
  /// Lowers the least distance of pairs of bodies that start the step below it. Returns whether any does.
  bool lower_separations();
  double freeze_friction(std::span<const Vec3> x);
  /// What restitution gives two bodies that are out of reach, between the vertices nearest to its line.
  ContactForce beyond_reach(const RestitutionSet::LineForce& given, std::span<const Vec3> x) const;
  /// Pairs that friction acts on keep the names that they have.
  void keep_names();
  /// Forces on sides A of the active contacts [N].
  std::vector<Vec3> forces(std::span<const Vec3> x) const;
  /// Whether it is the key of a contact of a point with a cell.
  bool is_name(const PairKey& key) const;
  std::map<int64_t, double> smallest_gaps(std::span<const Vec3> x);
  CloseBodies parted(std::span<const Vec3> x);
  void fill(const std::vector<Contact>& near, std::span<const Vec3> x, ContactSet& out);

  CandidateSearch search_;
  ContactGeometry geometry_;
  FrictionTable friction_coefficient_;
  ContactSettings settings_;
  ThreadPool& pool_;
  PhaseTimer& timer_;
  ContactLaw law_;
  SurfaceCells cells_;
  std::vector<PairKey> names_;  ///< of contacts of points, sorted: see merge_by_feature
  std::vector<Vec3> rest_positions_;
  ContactSet active_, trial_;
  /// What they were merged from: by primitives, without laws.
  std::vector<Contact> near_active_, near_trial_;
  /// Of the last find_contacts_at().
  std::vector<Contact> found_;
  HeldPositions x_found_;
  bool is_found_ = false;
  FrictionSet friction_;
  RestitutionSet restitution_;
  bool is_bound_ = true;
  CcdReport ccd_report_;
  std::vector<Vec3> x_reference_;
  HeldPositions x_active_, x_trial_;  ///< of the last update(), of the last energy_difference()
  /// Nothing but x decides what the next one gives; of is_near_ nothing but x and the names.
  bool is_active_ = false, is_trial_ = false, is_near_ = false;
  uint64_t revision_ = 1;
  double duration_ = 0.0, weight_ = 1.0;
  double friction_residual_ = 0.0;
  std::optional<LimitChange> unsettled_friction_;
};

}  // namespace stark
