// Where energies, or what materials remember, are not finite: at time 0, which is refused, and after the last
// attempt at a step.
#pragma once

#include <string>

#include <stark/sim/step/step_evidence.h>

namespace stark {

/// Elements with energies, derivatives or updates of internal variables that are not finite where the attempt
/// ended, one for each batch, and which variable it is.
void add_not_finite(const FailedStep& step, StepEvidence& out);

/// Throws InvalidArgument where a step of length h that ends where it starts, with sites at x, would leave an
/// internal variable without a finite value.
void require_finite_updates(const Scene& scene, const Model& model, Energies& energies,
                            std::span<const Vec3> x, double h);

}  // namespace stark
