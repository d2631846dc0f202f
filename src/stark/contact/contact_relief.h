// Stiffer contact for the rest of a step between bodies that an impact presses to next to nothing. Where
// surfaces with a radius of curvature R are a gap g apart, straight steps along them end after sqrt(2 R g) at
// what they would lead through, and a slide takes Newton's method as many of them. The law of the next step
// knows nothing of it: what stiffer contact has stored is gone by then. [theory eq. 18c]
#pragma once

#include <cstdint>
#include <functional>
#include <map>
#include <span>
#include <vector>

#include <stark/contact/contact_set.h>

namespace stark {

class ContactRelief {
 public:
  /// Begins a step that gets no relief.
  void begin() { *this = {}; }
  /// Allows it. energies: of contacts at the start of the step [J]; most: what relief may add to them in all
  /// [J].
  void allow(const std::vector<Contact>& contacts, std::span<const double> energies, double most);
  bool is_allowed() const { return is_allowed_; }

  /// Factor of the stiffness of contact between two bodies; bodies: group_code().
  double factor(int64_t bodies) const;
  /// Stiffens contact between bodies that `may_give_way` and that forces on sides A of contacts [N] press
  /// closer than a small part of their contact distance, until those forces keep a larger one. Returns
  /// whether there are any.
  bool stiffen(const std::vector<Contact>& contacts, std::span<const Vec3> forces,
               const std::function<bool(int64_t)>& may_give_way);
  /// What it has added to the energies at the start of the step [J].
  double added() const;

 private:
  std::map<int64_t, double> start_, factor_;  ///< by bodies: energies [J], and factors above 1
  double most_ = 0.0;
  bool is_allowed_ = false;
};

}  // namespace stark
