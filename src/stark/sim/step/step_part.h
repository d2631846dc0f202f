// What the parts of a time step work on. The Simulation owns all of it; it never moves while parts refer to
// it.
#pragma once

#include <vector>

#include <stark/base/thread_pool.h>
#include <stark/base/timer.h>
#include <stark/contact/pipeline.h>
#include <stark/mechanics/incremental_potential.h>
#include <stark/mechanics/state.h>
#include <stark/sim/model/energies.h>
#include <stark/sim/model/model.h>
#include <stark/sim/scene/scene.h>
#include <stark/sim/scene/settings.h>

namespace stark {

struct StepContext {
  const Scene& scene;
  const Settings& settings;
  const Model& model;
  Energies& energies;
  State& state;
  ContactPipeline* contact;  ///< null without contact
  IncrementalPotential& potential;
  std::vector<Vec3>& step_start;  ///< site positions that the last step started from [m]
  ThreadPool& pool;
  PhaseTimer& timer;
};

/// Names for what is in the context.
class StepPart {
 protected:
  explicit StepPart(const StepContext& context)
      : scene_(context.scene),
        settings_(context.settings),
        model_(context.model),
        energies_(context.energies),
        state_(context.state),
        contact_(context.contact),
        potential_(context.potential),
        step_start_(context.step_start),
        pool_(context.pool),
        timer_(context.timer) {}
  ~StepPart() = default;

  const Scene& scene_;
  const Settings& settings_;
  const Model& model_;
  Energies& energies_;
  State& state_;
  ContactPipeline* const contact_;
  IncrementalPotential& potential_;
  std::vector<Vec3>& step_start_;
  ThreadPool& pool_;
  PhaseTimer& timer_;
};

}  // namespace stark
