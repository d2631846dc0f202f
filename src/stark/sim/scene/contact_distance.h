// Contact distances of bodies: their own, that of the settings, or one that suits the body.
#pragma once

#include <span>
#include <string>
#include <vector>

#include <stark/sim/scene/scene.h>

namespace stark {

/// Contact distance of a body [m]: its own, else settings.contact.distance, else (0) an automatic one: 1 mm,
/// but at most 1 % of the diagonal of its box and, where the body can touch itself, at most half the smallest
/// height of its triangles; needles do not count beyond a tenth.
double contact_distance(const Scene& scene, BodyId body, const Settings& settings);

/// Distance over the largest coordinate below which surfaces touch: a thousand roundings.
inline constexpr double kTouching = 2e-13;

/// Throws where rounding of the coordinates of a body [m] swallows its contact distance.
void check_resolved(const Scene& scene, BodyId body, const Settings& settings, std::span<const Vec3> x);

/// What a scene with these settings should be warned about: contact distances above half the smallest height
/// of a triangle that can touch its own body, which makes a mesh press on itself at rest, and stacks of
/// sheets that are much thinner.
std::vector<std::string> check_contact_distances(const Scene& scene, const Settings& settings);

}  // namespace stark
