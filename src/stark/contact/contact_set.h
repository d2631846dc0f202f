// Active contacts of a configuration: candidate pairs whose distance is below their contact distance,
// classified into stencils and filled into one batch per barrier (step phase 4b).
#pragma once

#include <array>
#include <compare>
#include <memory>
#include <optional>
#include <span>
#include <vector>

#include <stark/collision/candidates.h>
#include <stark/collision/max_safe_step.h>
#include <stark/contact/edge_ranges.h>
#include <stark/mechanics/assembler.h>

namespace stark {

enum class StencilKind : uint8_t {
  PointPoint,
  PointEdge,
  PointTriangle,
  EdgeEdge,
  MollifiedPointPoint,
  MollifiedPointEdge,
  MollifiedEdgeEdge,
  kCount
};
inline constexpr int kStencilKindCount = static_cast<int>(StencilKind::kCount);

/// Ends of an edge, whichever way it was found.
inline Index2 sorted(int32_t a, int32_t b) { return a < b ? Index2{a, b} : Index2{b, a}; }

/// Identity of a pair of primitives, in the order of the candidate lists.
struct PairKey {
  /// Kind of what a point touches beside the cells that name its contacts (closest_features).
  static constexpr PairKind kOther{kPairKindCount};

  PairKind kind = PairKind::PointTriangle;  ///< or kOther
  int32_t first = 0, second = 0;
  auto operator<=>(const PairKey&) const = default;

  PrimitivePair pair() const { return {first, second}; }
};

struct Contact {
  PairKey key;
  StencilKind kind = StencilKind::PointPoint;
  int8_t point_count = 2;
  int8_t side_a_count = 1;  ///< the first vertices belong to side A
  int32_t group_a = 0, group_b = 0;
  std::array<int32_t, 4> sites{};   ///< as the barrier of `kind` orders them
  std::array<double, 4> weights{};  ///< separation = sum_i weights_i x_i, + on side A
  /// How often the energy of the stencil counts: see contact/closest_features.h.
  int32_t multiplicity = 1;
  double distance = 0.0;            ///< [m]
  double contact_distance = 0.0;    ///< [m]
  double least_distance = 0.0;      ///< at which the barrier is infinite [m]
  double parallel_threshold = 0.0;  ///< [m^4], edge-edge only
  double stiffness = 0.0;           ///< [N/m]
};

/// From the closest point of side B to that of side A, with the contact's weights, at site positions x [m].
inline Vec3 gap_vector(const Contact& contact, std::span<const Vec3> x) {
  Vec3 sum;
  for (int p = 0; p < contact.point_count; ++p) sum += x[contact.sites[p]] * contact.weights[p];
  return sum;
}

/// The closest point of side A, at site positions x [m].
inline Vec3 place_on_a(const Contact& contact, std::span<const Vec3> x) {
  Vec3 sum;
  for (int p = 0; p < contact.side_a_count; ++p) sum += x[contact.sites[p]] * contact.weights[p];
  return sum;
}

/// Number of an unordered pair of groups.
int64_t group_code(int32_t group_a, int32_t group_b);
/// That of the two bodies of a contact.
inline int64_t group_code(const Contact& contact) { return group_code(contact.group_a, contact.group_b); }
/// The groups of a number, the smaller one first.
inline std::pair<int32_t, int32_t> groups_of_code(int64_t code) {
  return {static_cast<int32_t>(code >> 32), static_cast<int32_t>(code & 0xffffffff)};
}

/// 1 where side A of a contact is of the first group of its number, -1 where it is of the second.
inline double side_of_first(const Contact& contact, int64_t code) {
  return contact.group_a == groups_of_code(code).first ? 1.0 : -1.0;
}

/// Pairs of bodies that started within their contact distance, and the smaller one that they have until they
/// part. Part of the State; sorted, without doubles.
struct CloseBodies {
  std::vector<int64_t> bodies;     ///< group_code()
  std::vector<double> distance{};  ///< [m]

  /// Distance of a pair, if it has one [m].
  std::optional<double> of(int64_t code) const;
  /// Gives a pair a distance, or another one [m].
  void set(int64_t code, double value);
};

/// What classification needs to know about the surfaces.
struct ContactGeometry {
  const SurfaceMesh* mesh = nullptr;
  std::vector<double> group_distance;       ///< contact distance per group [m]; a pair acts within the sum
  std::vector<double> edge_squared_length;  ///< of the rest shape, per edge [m^2]
  std::shared_ptr<const EdgeRanges> edge_ranges{};  ///< none: they act over their whole contact distance
  /// Per triangle the one that stands for its convex flat face, of which a point has one contact: that with
  /// the nearest triangle. Empty: each is a face.
  std::vector<int32_t> face{};
  CloseBodies close{};
  std::vector<uint8_t> prescribed{};  ///< by site, 1 where no force moves it; none: all are free
  /// By group, what no pressure takes of its contact distance [m], at most half of it; none: 0 for all.
  std::vector<double> group_core{};
  /// What collision detection keeps between two groups: the sum over both [m], or that of the pair.
  std::vector<double> group_separation{};
  std::vector<Separations::Pair> pair_separation{};
  bool has_least_distance = true;  ///< false: barriers act down to 0

  /// Contact distance of two groups [m].
  double distance(int32_t group_a, int32_t group_b) const;
  /// Core of two groups [m].
  double core(int32_t group_a, int32_t group_b) const;
  /// Within which two edges act whose flatness leaves them a part of the contact distance [m]. Where there is
  /// a core they bear on it as vertices do: collision detection would stop them there before they push.
  double edge_distance(const Contact& edges, double part) const;
  Separations separations() const;
  /// Where their barrier is infinite [m], which is just below what collision detection keeps.
  double least_distance(int32_t group_a, int32_t group_b) const;
};

/// Contacts among the candidates at site positions x, in the order of the lists. Stiffness is left at zero.
void find_contacts(const ContactGeometry& geometry, const CandidateList& candidates, std::span<const Vec3> x,
                   ThreadPool& pool, std::vector<Contact>& out);

class ContactSet {
 public:
  /// barriers: one potential per StencilKind.
  ContactSet(const std::array<std::shared_ptr<const Potential>, kStencilKindCount>& barriers,
             ThreadPool& pool);

  /// Takes the contacts (with stiffness) and fills the batches.
  void reset(std::vector<Contact> contacts);
  /// Changes places with another set of the same potentials; batches stay where they are.
  void swap(ContactSet& other);
  /// Factor of the energies and of what the batches have, from the next reset() on; forces are without it.
  void set_weight(double weight) { weight_ = weight; }

  const std::vector<Contact>& contacts() const { return contacts_; }
  std::vector<const PotentialBatch*> batches() const;

  /// Energies of the contacts at x, in the order of contacts(), with the weight [J].
  const std::vector<double>& evaluate_energies(std::span<const Vec3> x);
  const std::vector<double>& energies() const { return energies_; }
  /// Force vectors on side A of each contact at x: minus the sum of the gradients of its points [N].
  void evaluate_forces(std::span<const Vec3> x, std::vector<Vec3>& out) const;

 private:
  void set_fields(int kind, int64_t element);

  /// Numbers of the fields of a batch; without a threshold -1.
  struct Fields {
    int stiffness, distance, least_distance, parallel_threshold;
  };

  ThreadPool& pool_;
  std::vector<PotentialBatch> batches_;           ///< by StencilKind
  std::vector<Fields> fields_;                    ///< [kind]
  std::vector<std::vector<int64_t>> contact_of_;  ///< [kind][element] -> index into contacts_
  std::vector<Contact> contacts_;
  std::vector<double> energies_;
  double weight_ = 1.0;
};

/// Sum over pairs of energies of `b` minus energies of `a`; both sorted by key, missing pairs have no energy.
EnergyDifference energy_difference(const ContactSet& a, const ContactSet& b);

}  // namespace stark
