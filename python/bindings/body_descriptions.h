// Descriptions of bodies from the keyword arguments of the Python front end.
#pragma once

#include <nanobind/nanobind.h>

#include <stark/sim/scene.h>

namespace stark::bindings {

namespace nb = nanobind;

ClothDescription cloth_of(const nb::dict& given, const ShellMaterial& material);
SolidDescription solid_of(const nb::dict& given, const SolidMaterial& material);
RodDescription rod_of(const nb::dict& given, const RodMaterial& material);
RigidDescription rigid_of(const nb::dict& given);

}  // namespace stark::bindings
