// Collects what can be seen of a step that failed, in terms of bodies and vertices of the scene: unbalanced
// forces, gaps, what blocks the way, strained elements, rounding. Phase: after the last attempt at a step.
#pragma once

#include <span>
#include <vector>

#include <stark/linalg/block_matrix.h>
#include <stark/sim/model/model.h>
#include <stark/sim/step/diagnosis.h>

namespace stark {

/// Where the last attempt ended.
struct FailedStep {
  const Scene& scene;
  const Settings& settings;
  const Model& model;
  const Energies& energies;
  IncrementalPotential& potential;
  ContactPipeline* contact = nullptr;  ///< null without contact
  std::span<const Vec3> start;         ///< sites at the start of the step [m]
  const Configuration& target;         ///< of prescribed parts
  std::span<const double> direction;   ///< the last Newton step
  bool is_first_step = false;
  bool is_detour = false;  ///< refused for the pair that contact looked at last
};

/// All of it but what an attempt reports itself. Linearises the potential where it stands.
StepEvidence collect_evidence(const FailedStep& step);

/// What of it tells of energies of users. Linearises the potential, too.
StepEvidence collect_energy_evidence(const FailedStep& step);

/// At most `count` of some contacts, the narrowest over their contact distance first.
std::vector<NarrowGap> find_narrow_gaps(const Scene& scene, const Model& model,
                                        std::span<const Contact> contacts, size_t count);

/// What owns each block of unknowns, with its vertex; bodies are named as owner_text() does.
std::vector<BodyVertices> block_owners(const Scene& scene, const Model& model);

}  // namespace stark
