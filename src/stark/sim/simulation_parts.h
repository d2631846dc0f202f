// The parts of a simulation that take its steps: seen by the files simulation*.cpp only.
#pragma once

#include <stark/sim/simulation.h>
#include <stark/sim/step/step_runner.h>

namespace stark {

/// Places of sites at which nothing intersects, with these exclusions of contact over.
struct ClearPlaces {
  std::vector<Vec3> places{};
  std::vector<int64_t> regained{};
};

struct Simulation::Parts {
  Parts(const StepContext& context, Exclusions exclusions, const SurfaceMesh& mesh,
        const std::vector<bool>& is_filled, PrescribedBodies prescribed, Assembler& assembler,
        LinearSolver& linear_solver)
      : motion(context),
        joints(context, motion),
        ledger(context, motion),
        way(context, motion, std::move(prescribed)),
        watch(context, std::move(exclusions), mesh, is_filled),
        placing(context, motion, joints, ledger, mesh),
        runner(context, {motion, joints, ledger, way, watch, placing}, assembler, linear_solver) {}

  StepMotion motion;
  StepJoints joints;
  StepLedger ledger;
  StepWay way;
  ReleaseWatch watch;
  Placing placing;
  StepRunner runner;
  ClearPlaces known_clear{};  ///< of the state or placing that was checked last
};

}  // namespace stark
