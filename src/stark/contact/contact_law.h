// The law of contact: pressure [Pa] against the gap between two surfaces, the same for every time step and
// mesh (step phase 2).
//
// p(g) = P beta(g/d) with the pressure P of the pair at which the gap is half of the contact distance d, and
// beta(r) = -b'(r)/-b'(1/2) of the barrier b(r) = -(r - 1)^2 ln r. A contact that stands for the area A has
// the stiffness kappa = m P A/(|b'(1/2)| d), m its multiplicity. Two bodies are in series, d/P = d_A/P_A +
// d_B/P_B. [theory eq. 16a, 18]
//
// Where P was given to neither body, it says nothing of what is stacked on them: under a load that lasts, all
// contacts between two bodies get stiffer until the largest pressure is carried at a tenth of the contact
// distance. [theory eq. 18a]
#pragma once

#include <map>
#include <span>
#include <unordered_map>
#include <vector>

#include <stark/contact/area_weights.h>
#include <stark/contact/contact_relief.h>
#include <stark/contact/contact_set.h>
#include <stark/contact/load_memory.h>
#include <stark/contact/pressed_sheets.h>

namespace stark {

/// Contact stiffness of a body: the pressure at which the gap is half of the contact distance.
struct BodyStiffness {
  double pressure = 0.0;  ///< [Pa], infinity for what does not give way
  bool is_given = false;  ///< by the user: then it is a law, and no load changes it
};

/// What an impact with restitution has left of the layer of contact between two bodies.
struct SpentLayer {
  double stiffness = 1.0;  ///< over its own
  Vec3 normal;             ///< mean direction of the forces on the first body: only what faces it is spent
};

/// -b'(r) / -b'(1/2) of the barrier on the unit interval: pressure over contact stiffness at the gap r d.
double relative_pressure(double r);
/// -b'(r): force of a contact over its stiffness and contact distance at the gap r d.
double barrier_slope(double r);

class ContactLaw {
 public:
  ContactLaw() = default;
  /// By group: stiffness and contact distance [m].
  ContactLaw(AreaWeights areas, std::vector<BodyStiffness> bodies, std::vector<double> distance);

  /// Forgets the areas of the last step. spent: by bodies.
  void begin_step(LoadMemory memory = {}, std::map<int64_t, SpentLayer> spent = {});

  /// Sets the stiffness of each contact at x. Areas that depend on the normal are those of the first contact
  /// in the step of a vertex with a body, or of two edges. mesh: see PairKey.
  void assign(const SurfaceMesh& mesh, std::span<const Vec3> x, ThreadPool& pool,
              std::vector<Contact>& contacts);

  const AreaWeights& areas() const { return areas_; }
  ContactRelief& relief() { return relief_; }
  const ContactRelief& relief() const { return relief_; }
  /// Stiffens contact for the rest of the step, see ContactRelief; laws of users stay as they are. Returns
  /// whether any is stiffer.
  bool relieve(const std::vector<Contact>& contacts, std::span<const Vec3> forces);
  /// Pressure at half of the contact distance of two bodies, without the factor of their load [Pa].
  double pressure(int32_t group_a, int32_t group_b) const;
  /// Whether it is that of a user.
  bool is_given(int32_t group_a, int32_t group_b) const {
    return bodies_[group_a].is_given || bodies_[group_b].is_given;
  }

  /// What the loads at the end of a step ask of the next one. forces: on side A of each contact [N];
  /// duration: of the step, over the delay with which factors follow. Sheets between two bodies keep them
  /// apart as far as their own layers reach.
  LoadMemory end_step(const std::vector<Contact>& contacts, std::span<const Vec3> forces,
                      double duration = 1.0, std::span<const PressedSheet> sheets = {}) const;

  /// The factors of this step, raised to what contacts ask that were met on the way of a step which failed:
  /// an impact that presses a contact to a gap where Newton's method finds nothing any more. end_step()
  /// forgets them where the user gave the law.
  /// most: factors that bodies may get at most; none for those that are not in it.
  LoadMemory raised(const std::vector<Contact>& contacts, std::span<const Vec3> forces,
                    const std::map<int64_t, double>& most = {}) const;
  /// Largest factors with which contacts that store these energies [J] store no more than kMostStored times
  /// what all of them did with the factors of the step before, and beyond kStored times that no more than
  /// kPartOfMotion of `kinetic`, the energy of what moves [J].
  std::map<int64_t, double> highest_factors(const std::vector<Contact>& contacts,
                                            const std::vector<double>& energies, const LoadMemory& before,
                                            double kinetic) const;

 private:
  /// Largest factor that the loads ask for, by bodies: of those in contact, 0 for others that have one. Of a
  /// layer that an impact has spent as it is left, or as it was.
  std::map<int64_t, double> wanted(const std::vector<Contact>& contacts, std::span<const Vec3> forces,
                                   bool as_left) const;
  /// By how much more stiffness both contacts of a sheet need than wanted() says, so that the bodies do not
  /// press on each other through it. [theory eq. 18d]
  std::map<int64_t, double> sheet_factors(const std::vector<Contact>& contacts, std::span<const Vec3> forces,
                                          std::span<const PressedSheet> sheets) const;
  /// Factor of the stiffness of contact between two bodies, beside what an impact has spent.
  double factor(int64_t bodies) const { return memory_.find(bodies) * relief_.factor(bodies); }
  /// Part of its stiffness that an impact has left a contact.
  double left(const Contact& contact) const;
  /// Decides it for the rest of the step, by the directions in which a vertex meets a body first, or two
  /// edges each other: where one of them is not that of the impact nothing is spent, so that the terms of
  /// theory eq. 16c have one factor.
  void freeze_left(std::span<const Vec3> x, const std::vector<Contact>& contacts);
  void freeze_areas(const SurfaceMesh& mesh, std::span<const Vec3> x, const std::vector<Contact>& contacts);

  AreaWeights areas_;
  std::vector<BodyStiffness> bodies_;
  std::vector<double> distance_;
  LoadMemory memory_;
  ContactRelief relief_;
  std::map<int64_t, SpentLayer> spent_;
  std::map<int64_t, double> left_;              ///< of contacts of bodies in spent_, as frozen_
  std::unordered_map<int64_t, double> frozen_;  ///< areas of pairs of edges, or of a vertex and a body [m^2]
};

}  // namespace stark
