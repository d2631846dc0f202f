// Which 3-blocks of the unknown belong to which point or rigid body. Unknowns are increments: dx of a point
// [m], and (dt, dw) of a rigid body or of a node of a rod [m, rad]. What is prescribed has no unknowns:
// points, bodies, the translation of a pinned node.
#pragma once

#include <cstddef>
#include <cstdint>
#include <vector>

namespace stark {

inline constexpr int32_t kNoBlock = -1;

struct DofLayout {
  std::vector<int32_t> point_block;     ///< block of dx, or kNoBlock for a prescribed point
  std::vector<int32_t> body_block;      ///< block of dt, or kNoBlock where translation is prescribed
  std::vector<int32_t> rotation_block;  ///< block of dw, or kNoBlock where rotation is prescribed
  int32_t block_count = 0;

  /// Numbers the free points first, then the free bodies, dw of each behind its dt.
  static DofLayout build(const std::vector<bool>& point_is_prescribed,
                         const std::vector<bool>& body_is_prescribed) {
    return build(point_is_prescribed, body_is_prescribed, body_is_prescribed);
  }
  static DofLayout build(const std::vector<bool>& point_is_prescribed,
                         const std::vector<bool>& translation_is_prescribed,
                         const std::vector<bool>& rotation_is_prescribed) {
    DofLayout layout;
    for (const bool prescribed : point_is_prescribed)
      layout.point_block.push_back(prescribed ? kNoBlock : layout.block_count++);
    for (size_t b = 0; b < translation_is_prescribed.size(); ++b) {
      layout.body_block.push_back(translation_is_prescribed[b] ? kNoBlock : layout.block_count++);
      layout.rotation_block.push_back(rotation_is_prescribed[b] ? kNoBlock : layout.block_count++);
    }
    return layout;
  }
};

}  // namespace stark
