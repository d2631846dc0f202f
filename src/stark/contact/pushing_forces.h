// Normal forces that limit friction (step phase 2). Above a valley a point has a contact with each side, and
// a negative one with the edge between them, which takes away what both sides count (closest_features). The
// energies add up; limits of friction would not, for a negative contact has no friction. So what it takes
// away is taken from its neighbours: friction does not double where a surface bends inwards ever so little.
#pragma once

#include <span>
#include <vector>

#include <stark/contact/contact_set.h>

namespace stark {

/// Forces of contacts [N], those of negative contacts shared out among the positive contacts of the same
/// point beside them, in proportion to their size, and zero themselves. `contacts`: sorted by key.
std::vector<Vec3> pushing_forces(std::span<const Contact> contacts, std::vector<Vec3> forces);

}  // namespace stark
