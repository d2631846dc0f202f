// Scenes with layers: a block of tetrahedra, whose first vertices are a grid of 3 x 3 x 3 with x running
// first.
#pragma once

#include <exception>
#include <functional>
#include <string>

#include <stark/geometry/shapes.h>
#include <stark/sim/scene/scene.h>

namespace stark::test {

inline SolidDescription block_description(double size = 1.0) {
  return {.name = "block", .mesh = make_tet_box({size, size, size}, {2, 2, 2})};
}
inline BodyId add_block(Scene& scene) { return scene.add_solid(block_description()); }

/// What a call throws, empty if nothing.
inline std::string message_of(const std::function<void()>& call) {
  try {
    call();
  } catch (const std::exception& error) {
    return error.what();
  }
  return "";
}

inline bool contains(const std::string& text, const std::string& part) {
  return text.find(part) != std::string::npos;
}

}  // namespace stark::test
