// Forces that joints in closed loops do to each other, which move nothing: a door on two hinges whose axes
// are not quite on one line, a four-bar linkage in space (step phases 4j and 6). Residuals within the
// tolerances, which no motion closes, would raise them from step to step without end. [theory eq. 25a]
#pragma once

#include <functional>
#include <memory>
#include <optional>
#include <span>
#include <vector>

#include <stark/linalg/linear_solver.h>
#include <stark/mechanics/assembler.h>
#include <stark/mechanics/constraint_set.h>

namespace stark {

class SelfStress {
 public:
  /// Constraints whose groups and stencils stay as they are. `may_break`, by number: loops with such ones are
  /// torn, and keep all forces.
  SelfStress(const KinematicMap& map, ConstraintSet& constraints, ThreadPool& pool,
             std::function<bool(int32_t)> may_break);

  /// By residual, with sites at x: the part C' of which the forces rho C' move bodies as rho C does and are
  /// the least that do, weighed by 1 / rho; C itself where no constraints that act are in a loop.
  std::vector<double> held(const Configuration& configuration, std::span<const Vec3> x);

  /// What the constraints leave to the next step.
  struct End {
    std::vector<double> forces;       ///< the least that move bodies as lambda + rho C does
    std::vector<double> multipliers;  ///< with which they are that again if nothing moves
  };
  End end(const Configuration& configuration, std::span<const Vec3> x);

 private:
  /// A constraint, the blocks that move it, and how many independent rows these must carry.
  struct Member {
    int32_t joint = 0;
    size_t rows = 0;
    std::vector<int32_t> blocks;  ///< each once
  };

  /// Which of the members that act are in loops.
  std::vector<bool> in_loops(const std::vector<bool>& acts) const;
  /// Which of the members that act are joined to a loop that may break.
  std::vector<bool> joined_to_torn(const std::vector<bool>& acts, const std::vector<bool>& loops) const;
  size_t row_count(const Member& member) const;
  size_t first_row(const Member& member) const;
  /// Which residuals act in a step that ends with these, but for loops that may break; empty where nothing
  /// that acts is in another loop.
  std::vector<bool> acting(std::span<const double> residuals) const;
  /// The part of rho C that moves bodies; nothing without a solution.
  std::optional<std::vector<double>> by_residuals(const Configuration& configuration, std::span<const Vec3> x,
                                                  std::span<const double> residuals,
                                                  const std::vector<bool>& acts);
  void factorise(const Configuration& configuration, std::span<const Vec3> x);
  /// The part of forces that moves bodies; nothing without a solution.
  std::optional<std::vector<double>> moving_part(const Configuration& configuration, std::span<const Vec3> x,
                                                 std::vector<double> forces, const std::vector<bool>& acts);
  /// Unknowns by which it comes about; empty without a solution.
  std::vector<double> displacements(const Configuration& configuration, std::span<const Vec3> x,
                                    std::span<const double> forces);
  /// Change of residuals per unit of displacements.
  std::vector<double> rates(const Configuration& configuration, std::span<const Vec3> x,
                            std::span<const double> displacements) const;

  const KinematicMap& map_;
  ConstraintSet& constraints_;
  std::function<bool(int32_t)> may_break_;
  std::vector<Member> members_;
  std::unique_ptr<Assembler> assembler_;  ///< null where no loop is possible
  std::unique_ptr<LinearSolver> solver_;
  std::vector<double> gradient_;
  BlockMatrix hessian_;
  bool is_factorised_ = false;
};

}  // namespace stark
