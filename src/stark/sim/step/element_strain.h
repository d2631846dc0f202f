// Elements of a body that are far from their rest shape: inverted ones, then those with the longest and the
// shortest edges. Used to diagnose a step that failed.
#pragma once

#include <span>
#include <vector>

#include <stark/sim/scene/scene.h>
#include <stark/sim/step/diagnosis.h>

namespace stark {

/// At most `count` elements of a cloth, solid or rod with vertices at x [m], the worst first: those that are
/// not as at rest to a tenth. None of rigid bodies.
std::vector<StrainedElement> find_strained_elements(const Scene& scene, BodyId body, std::span<const Vec3> x,
                                                    size_t count);

/// The two pins of a body that are farthest apart at x [m], over the length of the body between them along
/// its edges at rest; unset for fewer than two pins. Where there are many, for some that lie far apart.
std::optional<PinPair> find_stretched_pins(const Scene& scene, BodyId body, std::span<const Vec3> x);

/// How bad the strain of an element is: infinite where inverted, else the logarithm of the largest ratio.
double severity(const StrainedElement& element);

}  // namespace stark
