// Sheets that two bodies press on from both sides (step phase 5): where the layers of contact between them
// and the sheet give way too far, the two press on each other through it. [theory eq. 18d]
#pragma once

#include <compare>
#include <cstdint>
#include <span>
#include <vector>

#include <stark/contact/area_weights.h>
#include <stark/contact/contact_set.h>

namespace stark {

/// A sheet and two other bodies, by group, the lower one first.
struct PressedSheet {
  int32_t sheet = 0, low = 0, high = 0;
  auto operator<=>(const PressedSheet&) const = default;
};

/// Of which a vertex is pressed by both bodies, or that lies between a vertex of one and the other. Sorted.
/// contacts: sorted by key; forces: on side A of each [N]; areas: which groups are sheets.
std::vector<PressedSheet> find_pressed_sheets(const AreaWeights& areas, std::span<const Contact> contacts,
                                              std::span<const Vec3> forces);

}  // namespace stark
