// Contact distances of bodies: their own, that of the settings, or one that suits the body.
#pragma once

#include <string>
#include <vector>

#include <stark/sim/scene.h>

namespace stark {

/// Contact distance of a body [m]: its own, else settings.contact.distance, else (0) an automatic one: 1 mm,
/// but at most 1 % of the diagonal of its box and, where the body can touch itself, at most half the smallest
/// height of its triangles; needles do not count beyond a tenth.
double contact_distance(const Scene& scene, BodyId body, const Settings& settings);

/// What a scene with these settings should be warned about: contact distances above half the smallest height
/// of a triangle (the shortest edge of a rod) that can touch its own body, which makes a mesh press on itself
/// at rest.
std::vector<std::string> check_contact_distances(const Scene& scene, const Settings& settings);

}  // namespace stark
