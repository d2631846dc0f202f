#include <stark/contact/pushing_forces.h>

#include <algorithm>

namespace stark {

namespace {

/// Whether the closest features of two contacts of a point have a vertex in common.
bool are_neighbours(const Contact& a, const Contact& b) {
  const auto feature = [](const Contact& c) { return std::span(c.sites).subspan(1, c.point_count - 1); };
  return a.group_b == b.group_b && std::ranges::find_first_of(feature(a), feature(b)) != feature(a).end();
}

/// The contacts of the point of `negative` that it takes from: what it takes is theirs in sum.
std::vector<size_t> neighbours_of(size_t negative, std::span<const Contact> contacts,
                                  std::span<const Vec3> forces, std::span<const size_t> of_point) {
  std::vector<size_t> found;
  for (const size_t c : of_point)
    if (contacts[c].multiplicity > 0 && are_neighbours(contacts[negative], contacts[c]) &&
        dot(forces[c], forces[negative]) < 0.0)
      found.push_back(c);
  return found;
}

}  // namespace

std::vector<Vec3> pushing_forces(std::span<const Contact> contacts, std::vector<Vec3> forces) {
  std::vector<size_t> negative;
  for (size_t c = 0; c < contacts.size(); ++c)
    if (contacts[c].multiplicity < 0) negative.push_back(c);
  std::vector<double> taken(negative.empty() ? 0 : contacts.size(), 0.0);
  // Those of points come first in the order of keys, by point; negative ones after them.
  const auto by_point = [&](PairKind kind, int32_t point) {
    return std::ranges::equal_range(contacts, std::pair{kind, point}, {},
                                    [](const Contact& c) { return std::pair{c.key.kind, c.key.first}; });
  };
  for (const size_t n : negative) {
    std::vector<size_t> of_point;
    for (const PairKind kind : {PairKind::PointTriangle, PairKind::PointEdge})
      for (const Contact& c : by_point(kind, contacts[n].key.first))
        of_point.push_back(static_cast<size_t>(&c - contacts.data()));
    const std::vector<size_t> neighbours = neighbours_of(n, contacts, forces, of_point);
    double sum = 0.0;
    for (const size_t c : neighbours) sum += norm(forces[c]);
    if (!(sum > 0.0)) continue;
    for (const size_t c : neighbours) taken[c] += norm(forces[n]) / sum;
  }
  for (const size_t n : negative) forces[n] = {};
  for (size_t c = 0; c < taken.size(); ++c)
    if (taken[c] > 0.0) forces[c] = forces[c] * std::max(0.0, 1.0 - taken[c]);
  return forces;
}

}  // namespace stark
