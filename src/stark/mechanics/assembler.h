// Runs all batches, applies the maps and fills gradient and block matrix (step phases 4c to 4f).
//
// Batches are static (elasticity, inertia: their stencils never change) or dynamic (contact: set anew when
// the active set changes). Large static batches on plain points are assembled chunk by chunk while the
// element Hessians are in cache; chunks are coloured so that no two chunks of a colour share a block, hence
// no atomics and one order of sums whatever the number of threads. Elements with quadrature points are always
// static and on plain points, and have a plan of their own (quadrature_plan.h). All other batches are
// evaluated in parallel into a buffer and added in order, row by row on several threads where all their
// sites are points (point_scatter.h).
#pragma once

#include <span>
#include <vector>

#include <stark/base/thread_pool.h>
#include <stark/linalg/block_matrix.h>
#include <stark/mechanics/chunk_colouring.h>
#include <stark/mechanics/element_scatter.h>
#include <stark/mechanics/embedded_assembly.h>
#include <stark/mechanics/energy_difference.h>
#include <stark/mechanics/kinematic_map.h>
#include <stark/mechanics/lane_congruence.h>
#include <stark/mechanics/point_scatter.h>
#include <stark/mechanics/potential_batch.h>
#include <stark/mechanics/quadrature_plan.h>
#include <stark/mechanics/site_sums.h>
#include <stark/solve/low_rank.h>

namespace stark {

struct AssemblyOptions {
  bool project = false;  ///< make every element Hessian and every rigid curvature positive semidefinite
  /// Displacement that prescribed sites still have to make in this solve [m], by site; empty when there is
  /// none. The gradient then is the one at the end of that motion to first order.
  std::span<const Vec3> pending;
  /// Which blocks of the Hessian are wanted; Diagonal leaves out others as far as that saves time.
  ScatterPairs pairs = ScatterPairs::All;
};

class Assembler {
 public:
  Assembler(const KinematicMap& map, ThreadPool& pool);
  ThreadPool& pool() const { return pool_; }

  void set_static_batches(const std::vector<PotentialBatch*>& batches,
                          const std::vector<const QuadratureBatch*>& quadrature = {});
  /// Pattern of the static batches alone.
  const BlockPattern& static_pattern() const { return static_pattern_; }
  /// Merges the pattern with the one of the dynamic batches.
  void set_dynamic_batches(std::vector<const PotentialBatch*> batches);

  /// Gradient [N, N m] and Hessian of all batches at the configuration with site positions x; also remembers
  /// the energy of every static element for energy_difference().
  void assemble(const Configuration& configuration, std::span<const Vec3> x, const AssemblyOptions& options,
                std::span<double> out_gradient, BlockMatrix& out_hessian);
  /// What the Hessian of the last assemble() has beside its blocks: of energies of totals.
  const LowRank& low_rank() const { return low_rank_; }
  /// Gradient alone, with the energies that energy_difference() compares with.
  void assemble_gradient(const Configuration& configuration, std::span<const Vec3> x,
                         std::span<double> out_gradient);

  /// Energies of the static batches at x minus those at the last assemble(), summed element by element.
  EnergyDifference static_energy_difference(std::span<const Vec3> x);
  /// Total energy of static batch k at the last assemble() [J].
  double static_energy(size_t batch) const;
  int64_t projected_element_count() const { return projected_count_; }

 private:
  struct StaticPlan {
    PotentialBatch* batch = nullptr;
    bool is_plain = false;                    ///< all sites are points: identity maps
    std::vector<int32_t> blocks;              ///< plain: per element and point
    std::vector<PairPlace> places;            ///< plain: in the static pattern, per element and pair i <= j
    std::vector<std::vector<Chunk>> colours;  ///< plain: chunks that may run at the same time
    std::vector<double> energies;             ///< at the last assemble()
  };

  StaticPlan plan(PotentialBatch& batch) const;
  void append_pairs(std::span<const int32_t> stencils, int nodes,
                    std::vector<std::pair<int32_t, int32_t>>& out) const;
  void assemble_plain(StaticPlan& plan, std::span<const Vec3> x, const AssemblyOptions& options,
                      std::span<double> gradient, BlockMatrix& hessian);
  void assemble_chunk(StaticPlan& plan, const Chunk& chunk, std::span<const Vec3> x,
                      const AssemblyOptions& options, std::span<double> gradient, BlockMatrix& hessian);
  /// What prescribed sites that still have to move add to the gradient, for a block of lanes.
  void add_pending(const StaticPlan& plan, int64_t block, const double* lanes, std::span<const Vec3> pending,
                   std::span<double> gradient) const;
  void assemble_mapped(const PotentialBatch& batch, const Configuration& configuration,
                       std::span<const Vec3> x, const AssemblyOptions& options, std::span<double> gradient,
                       BlockMatrix& hessian, double* out_energies);
  /// Blocks of sites that are points, kNoBlock for prescribed sites; false if there are others.
  bool find_point_blocks(std::span<const int32_t> sites);
  /// Adds the elements of a block of lanes: `out` are the outputs of the kernel.
  void add_mapped_block(const PotentialBatch& batch, int64_t block, const double* out,
                        const Configuration& configuration, const AssemblyOptions& options,
                        std::span<double> gradient, BlockMatrix& hessian);
  void add_site_gradients(const PotentialBatch& batch, std::span<const Vec3> x, double* out_energies);
  /// Adds the Hessian of an energy in its totals, and what it makes of pending motion.
  void add_low_rank(const PotentialBatch& batch, const Configuration& configuration, std::span<const Vec3> x,
                    const AssemblyOptions& options, std::span<double> gradient);
  void add_rigid_curvature(const AssemblyOptions& options, BlockMatrix& hessian) const;

  const KinematicMap& map_;
  ThreadPool& pool_;
  std::vector<StaticPlan> static_plans_;
  std::vector<QuadraturePlan> quadrature_plans_;
  std::vector<const PotentialBatch*> dynamic_batches_;
  BlockPattern static_pattern_, pattern_;
  std::vector<std::pair<int32_t, int32_t>> dynamic_pairs_;  ///< that pattern_ was merged with
  std::vector<int64_t> slot_of_static_;  ///< slot in pattern_ of each slot of static_pattern_
  ScratchBuffer<double> buffer_;
  PointScatter point_scatter_;
  LaneCongruence congruence_;
  std::vector<SiteJacobian> jacobians_;    ///< of a block of lanes, [lane][point]
  std::vector<int32_t> blocks_;            ///< of one element
  std::vector<Vec3> extra_;                ///< of one element: gradient of pending motion
  AlignedVector<double> padded_gradient_;  ///< [block][4] of plain static batches
  SiteSums site_gradient_;                 ///< [N]
  LowRank low_rank_;
  SitePairs site_pairs_;           ///< of embedded sites, to be scattered at the end
  std::vector<Mat3> body_moment_;  ///< sum of g r^T per body
  std::atomic<int64_t> projected_count_{0};
};

}  // namespace stark
