#include <stark/contact/contact_relief.h>

#include <algorithm>

#include <stark/contact/contact_law.h>

namespace stark {

namespace {

/// Parts of the contact distance: forces that keep less than the first keep the second afterwards.
constexpr double kDeep = 0.03, kRelieved = 0.1;

constexpr double kMostGrowth = 1e3;  ///< of a factor at once

}  // namespace

void ContactRelief::allow(const std::vector<Contact>& contacts, std::span<const double> energies,
                          double most) {
  is_allowed_ = true;
  most_ = most;
  for (size_t c = 0; c < contacts.size(); ++c)
    if (energies[c] > 0.0) start_[group_code(contacts[c])] += energies[c];
}

double ContactRelief::factor(int64_t bodies) const {
  const auto found = factor_.find(bodies);
  return found == factor_.end() ? 1.0 : found->second;
}

bool ContactRelief::stiffen(const std::vector<Contact>& contacts, std::span<const Vec3> forces,
                            const std::function<bool(int64_t)>& may_give_way) {
  std::map<int64_t, double> pressed;  // largest force over stiffness and distance, by bodies
  for (size_t c = 0; c < contacts.size(); ++c) {
    if (!(contacts[c].stiffness > 0.0)) continue;
    double& largest = pressed[group_code(contacts[c])];
    largest = std::max(largest, norm(forces[c]) / (contacts[c].stiffness * contacts[c].contact_distance));
  }
  bool any = false;
  const double deep = barrier_slope(kDeep), relieved = barrier_slope(kRelieved);
  for (const auto& [bodies, force] : pressed) {
    if (force < deep || !may_give_way(bodies)) continue;
    const double before = factor(bodies);
    double after = before * std::min(force / relieved, kMostGrowth);
    if (const auto start = start_.find(bodies); start != start_.end())
      after = std::min(after, before + std::max(most_ - added(), 0.0) / start->second);
    if (!(after > before)) continue;
    factor_[bodies] = after;
    any = true;
  }
  return any;
}

double ContactRelief::added() const {
  double sum = 0.0;
  for (const auto& [bodies, factor] : factor_)
    if (const auto start = start_.find(bodies); start != start_.end()) sum += start->second * (factor - 1.0);
  return sum;
}

}  // namespace stark
