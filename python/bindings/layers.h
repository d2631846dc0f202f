// Layers of bodies at the border.
#pragma once

#include <nanobind/nanobind.h>

#include <stark/sim/simulation.h>

#include "arrays.h"

namespace stark::bindings {

/// {"name", "body", "triangles" (m, 3) or None, "rest_angles", "law", "fields", "color"} -> index
int32_t add_skin(Scene& scene, const nb::dict& given, const ShellMaterial& material);
/// {"name", "body", "vertices" of all paths in a row, "counts" of each, "bending", "rest_shape", "normal",
/// "law", "fields", "color"} -> index
int32_t add_fibres(Scene& scene, const nb::dict& given, const RodMaterial& material);
void bind_layers_of_scene(nb::handle type);
void bind_layers_of_simulation(nb::handle type);

}  // namespace stark::bindings
