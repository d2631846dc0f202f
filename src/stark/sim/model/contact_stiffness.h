// Contact stiffness of bodies: their own, that of the settings, or one by their weight.
#pragma once

#include <stark/contact/contact_law.h>
#include <stark/sim/model/model.h>

namespace stark {

/// Pressure at which the gap is half of the contact distance [Pa]: the body's own, else
/// settings.contact.stiffness, else (0) settings.contact.stiffness_factor times the weight of the body under
/// standard gravity over half of its surface (all of a sheet; of a rod its diameter times its length, at most
/// four diameters). Fixed
/// and scripted bodies without a value do not give way.
BodyStiffness contact_stiffness(const Scene& scene, const Model& model, BodyId body,
                                const Settings& settings);

}  // namespace stark
