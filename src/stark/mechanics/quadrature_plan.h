// Assembly of elements with quadrature points, chunk by chunk in colours (step phases 4c to 4f): the law and
// its projection at the points, B^T P B with the gradients of the shape functions, sums in a fixed order.
// Positive semidefinite Hessians of the law stay so under B^T P B. Internal to the assembler.
#pragma once

#include <atomic>
#include <span>
#include <vector>

#include <stark/base/thread_pool.h>
#include <stark/linalg/block_matrix.h>
#include <stark/mechanics/chunk_colouring.h>
#include <stark/mechanics/element_scatter.h>
#include <stark/mechanics/energy_difference.h>
#include <stark/mechanics/quadrature_batch.h>
#include <stark/mechanics/site_sums.h>

namespace stark {

/// Gradient and stiffness of one element. Gradient: [3 i][padded a]. Stiffness: entry (3 i + k) of the outer
/// index, rows a, padded columns b: d^2 E / dx_ai dx_bk, for b >= a.
struct ElementStiffness {
  AlignedVector<double> gradient;
  AlignedVector<double> values;
};

class QuadraturePlan {
 public:
  QuadraturePlan(const QuadratureBatch& batch, const KinematicMap& map, const BlockPattern& pattern);

  struct Target {
    bool project = false;
    std::span<const Vec3> pending;          ///< see AssemblyOptions
    std::span<const int64_t> slot_of_plan;  ///< slot in `hessian` of each slot of the plan's pattern
    std::span<double> gradient;
    BlockMatrix& hessian;
    std::atomic<int64_t>& projected_count;  ///< in points
  };
  /// Adds all elements to the target and remembers their energies.
  void assemble(ThreadPool& pool, std::span<const Vec3> x, const Target& target);
  /// Adds the gradient by site and remembers the energies.
  void add_site_gradients(ThreadPool& pool, std::span<const Vec3> x, SiteSums& sums);
  /// Energies at x minus those at the last assemble().
  EnergyDifference energy_difference(ThreadPool& pool, std::span<const Vec3> x) const;

 private:
  void assemble_chunk(const Chunk& chunk, std::span<const Vec3> x, const Target& target);
  /// Whether some point of a group has energy. `work`: a number for each lane.
  bool has_energy(std::span<const Vec3> x, int64_t group, std::span<double> work) const;
  /// `law`: outputs of the group's blocks of lanes; element numbers count from the group's first.
  /// Sum of the stresses at the points times the gradients of the shape functions: [3 i][padded a].
  void compute_gradient(int64_t element, const double* law, int outputs, int64_t first_lane,
                        std::span<double> out) const;
  void compute_stiffness(int64_t element, const double* law, int64_t first_lane, ElementStiffness& out) const;
  /// What the volume ratio of elements of mean dilatation brings to the stiffness beside the slabs in F.
  void add_coupling(int64_t element, const double* law, int64_t first_lane, ElementStiffness& out) const;
  void add_element(int64_t element, const ElementStiffness& stiffness, const Target& target) const;
  Vec3 pending_force(const ElementStiffness& stiffness, int a, std::span<const int32_t> nodes,
                     std::span<const Vec3> pending) const;

  const QuadratureBatch& batch_;
  const KinematicMap& map_;
  std::vector<PairPlace> places_;  ///< per element and pair of nodes a <= b
  std::vector<std::vector<Chunk>> colours_;
  std::vector<double> energies_;  ///< by element, at the last assemble()
};

}  // namespace stark
