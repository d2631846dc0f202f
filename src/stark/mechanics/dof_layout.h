// Which 3-blocks of the unknown belong to which point or rigid body. Unknowns are increments: dx of a point
// [m], and (dt, dw) of a rigid body [m, rad]. Prescribed points and bodies have no unknowns.
#pragma once

#include <cstdint>
#include <vector>

namespace stark {

inline constexpr int32_t kNoBlock = -1;

struct DofLayout {
  std::vector<int32_t> point_block;  ///< block of dx, or kNoBlock for a prescribed point
  std::vector<int32_t>
      body_block;  ///< block of dt (dw is the next one), or kNoBlock for a fixed or scripted body
  int32_t block_count = 0;

  /// Numbers the free points first, then the free bodies.
  static DofLayout build(const std::vector<bool>& point_is_prescribed,
                         const std::vector<bool>& body_is_prescribed) {
    DofLayout layout;
    for (const bool prescribed : point_is_prescribed)
      layout.point_block.push_back(prescribed ? kNoBlock : layout.block_count++);
    for (const bool prescribed : body_is_prescribed) {
      layout.body_block.push_back(prescribed ? kNoBlock : layout.block_count);
      if (!prescribed) layout.block_count += 2;
    }
    return layout;
  }
};

}  // namespace stark
