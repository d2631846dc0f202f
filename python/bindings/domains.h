// What binds each domain to the module, and the names that all files of the bindings use. Only nanobind is
// included here: module.cpp, which is compiled for any x86-64, includes it.
#pragma once

#include <nanobind/nanobind.h>

namespace stark::bindings {

namespace nb = nanobind;
using namespace nb::literals;

void bind_geometry(nb::module_& m);
void bind_settings(nb::module_& m);
void bind_scene(nb::module_& m);
void bind_solid_mesh(nb::module_& m);
void bind_state(nb::module_& m);
void bind_report(nb::module_& m);      ///< of steps, also of those that failed or are under way
void bind_simulation(nb::module_& m);  ///< with what it reports of contact
void bind_io(nb::module_& m);
void bind_formulas(nb::module_& m);
void bind_definitions(nb::module_& m);  ///< of potentials, laws, joints and actuators
void bind_symbolic(nb::module_& m);

}  // namespace stark::bindings
