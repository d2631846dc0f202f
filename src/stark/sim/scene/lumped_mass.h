// Masses of bodies and layers: lumped at the vertices, and in total. Phase: model building.
#pragma once

#include <vector>

#include <stark/sim/scene/scene.h>

namespace stark {

/// Mass of each vertex [kg].
std::vector<double> lumped_masses(const ClothDescription& cloth);
std::vector<double> lumped_masses(const SolidDescription& solid);
/// What a layer adds to the vertices of its body [kg]; zero where it has none.
std::vector<double> lumped_masses(const Scene& scene, const SkinDescription& skin);
std::vector<double> lumped_masses(const Scene& scene, const FibresDescription& fibres);

/// Mass of a body with all of its layers [kg]; 0 for fixed and scripted bodies.
double total_mass(const Scene& scene, BodyId body);
double total_mass(const Scene& scene, const SkinDescription& skin);
double total_mass(const Scene& scene, const FibresDescription& fibres);

}  // namespace stark
