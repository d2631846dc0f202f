// What binds each domain to the module. Nothing else is included here: module.cpp, which is compiled for any
// x86-64, includes it.
#pragma once

#include <nanobind/nanobind.h>

void bind_geometry(nanobind::module_& m);
void bind_laws(nanobind::module_& m);
void bind_settings(nanobind::module_& m);
void bind_scene(nanobind::module_& m);
void bind_solid_mesh(nanobind::module_& m);
void bind_state(nanobind::module_& m);
void bind_report(nanobind::module_& m);  ///< of steps, with the diagnosis of those that failed
void bind_step_progress(nanobind::module_& m);
void bind_simulation(nanobind::module_& m);
void bind_io(nanobind::module_& m);
void bind_potentials(nanobind::module_& m);
void bind_formulas(nanobind::module_& m);
void bind_definitions(nanobind::module_& m);  ///< of joints and actuators
void bind_contacts(nanobind::module_& m);
void bind_symbolic(nanobind::module_& m);
