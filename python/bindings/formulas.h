// Descriptions of energies and their points at the border.
#pragma once

#include <nanobind/nanobind.h>

#include <string>

#include <stark/sim/point_set.h>
#include <stark/sim/simulation.h>
#include <stark/symbolic/kernel.h>

#include "arrays.h"

namespace stark::bindings {

/// Throws InvalidArgument for unknown names.
symbolic::Backend to_backend(const std::string& name);
/// {"kind": "vertices" | "point" | "direction" | "embedded" | "world", "body": index, ...}
PointSet to_point_set(const nb::dict& given);
/// {"name", "formula_name", "doc", "formula", "translation_invariant", "points": [...], "values": {...}} ->
/// index
int32_t add_energy(Scene& scene, const nb::dict& given);
void set_energy_value(Simulation& simulation, int32_t energy, const std::string& name, nb::handle values);

}  // namespace stark::bindings
