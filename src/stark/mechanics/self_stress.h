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
#include <stark/mechanics/loop_system.h>

namespace stark {

class SelfStress {
 public:
  /// What is known of constraints by their numbers.
  using Known = std::function<bool(int32_t)>;
  /// Constraints whose groups and stencils stay as they are. Loops with some that may break keep all forces
  /// if what is driven may tear them, or if they fit no more.
  SelfStress(const KinematicMap& map, ConstraintSet& constraints, ThreadPool& pool, Known may_break,
             Known is_driven);

  /// By residual, with sites at x: the part C' of which the forces rho C' move bodies as rho C does and are
  /// the least that do, weighed by 1 / rho; empty where no constraints that act are in a loop.
  std::vector<double> held(const Configuration& configuration, std::span<const Vec3> x,
                           std::span<const double> residuals);

  /// What the constraints leave to the next step.
  struct End {
    /// The least that move bodies as lambda + rho C does, and rho times the misfits of what they tear.
    std::vector<double> forces;
    std::vector<double> multipliers;  ///< with which they are that again if nothing moves
    std::vector<double> misfits;      ///< parts of residuals that no motion closes; empty without a loop
  };
  End end(const Configuration& configuration, std::span<const Vec3> x);

 private:
  /// A constraint, the blocks that move it, and how many independent rows these must carry.
  struct Member {
    int32_t joint = 0;
    size_t rows = 0;
    std::vector<int32_t> blocks;  ///< each once
  };
  static std::vector<Member> members_of(const KinematicMap& map, const ConstraintSet& constraints);

  /// Which of the members that act are in loops.
  std::vector<bool> in_loops(const std::vector<bool>& acts) const;
  /// Which of the members that act are joined to one of `some`.
  std::vector<bool> joined_to(const std::vector<bool>& some, const std::vector<bool>& acts) const;
  /// Which of the members that act are joined to a loop that may break.
  std::vector<bool> joined_to_breakable(const std::vector<bool>& acts, const std::vector<bool>& loops) const;
  /// Which members have residuals that act.
  std::vector<bool> members_of(const std::vector<bool>& rows) const;
  /// Residuals of loops that may break and of which these misfits are nearly beyond the tolerances.
  std::vector<bool> torn(std::span<const double> misfits, const std::vector<bool>& acts) const;
  size_t row_count(const Member& member) const;
  size_t first_row(const Member& member) const;
  struct Acting {
    std::vector<bool> rows;   ///< residuals that act, but for loops that what is driven may tear
    std::vector<bool> loops;  ///< members in loops of what acts
  };
  /// In a step that ends with these residuals; no rows where nothing that acts is in such a loop.
  Acting acting_with(std::span<const double> residuals) const;
  /// Makes system_ of the members in loops, where it is of others, and takes over where they are.
  void read(const std::vector<bool>& loops, const Configuration& configuration, std::span<const Vec3> x);
  void make_system(const std::vector<bool>& loops);

  // Of the constraints in loops, by rows of system_:

  /// The part of rho C that moves bodies; nothing without a solution.
  std::optional<std::vector<double>> by_residuals(std::span<const double> residuals,
                                                  const std::vector<bool>& acts);
  void factorise();
  /// The part of forces that moves bodies; nothing without a solution.
  std::optional<std::vector<double>> moving_part(std::vector<double> forces, const std::vector<bool>& acts);
  /// Unknowns by which it comes about; empty without a solution.
  std::vector<double> displacements(std::span<const double> forces);
  /// Change of residuals per unit of displacements.
  std::vector<double> rates(std::span<const double> displacements) const;

  const KinematicMap& map_;
  ConstraintSet& constraints_;
  ThreadPool& pool_;
  Known may_break_, is_driven_;
  std::vector<Member> members_;
  bool is_loop_possible_ = false;
  std::vector<bool> loops_;  ///< members that system_ is made of
  std::unique_ptr<LoopSystem> system_;
  std::vector<Member> system_members_;
  std::unique_ptr<Assembler> assembler_;
  std::unique_ptr<LinearSolver> solver_;
  std::vector<double> gradient_;
  BlockMatrix hessian_;
  bool is_factorised_ = false;
};

}  // namespace stark
