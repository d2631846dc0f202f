// J^T H J of all elements of a block of lanes at once, straight from the lanes in which kernels leave their
// Hessians (step phase 4e). Sites that the same body moves are summed before the chain rule is applied: the
// eight sites of a joint make two groups, the four of a contact between rigid bodies two. [theory eq. 5]
#pragma once

#include <array>
#include <cstdint>
#include <span>
#include <vector>

#include <stark/base/aligned.h>
#include <stark/linalg/block_matrix.h>
#include <stark/mechanics/element_scatter.h>
#include <stark/mechanics/kinematic_map.h>
#include <stark/symbolic/kernel.h>

namespace stark {

class LaneCongruence {
 public:
  /// Takes the sites of the first `lane_count` lanes, [lane][point]. False, and nothing else may be called,
  /// where a site follows several points.
  bool begin(std::span<const SiteJacobian> jacobians, int points, int lane_count);
  /// Maps the Hessians; `upper` is [n(n+1)/2][kLanes], n = 3 points.
  void multiply(const double* upper);
  /// Adds the mapped Hessian of one lane.
  void scatter(int lane, BlockMatrix& hessian, ScatterPairs which) const;

 private:
  static constexpr int kLanes = symbolic::kLanes;

  /// What moves a site or a group along, and what turns it: kNoBlock where nothing does.
  struct Blocks {
    int32_t move = kNoBlock, turn = kNoBlock;
    bool admits(const Blocks& other) const;
  };
  struct SiteLanes {
    std::array<double, kLanes> weight{};                ///< of the motion along, 0 where there is none
    std::array<std::array<double, kLanes>, 3> lever{};  ///< [m], 0 where nothing turns the site
    bool moves = false, turns = false;                  ///< in any lane
    int group = 0;
  };
  /// A 3x3 matrix of each lane: [half of the lanes][9][lane of the half].
  using Matrices = std::array<double, 9 * kLanes>;
  /// Of two groups f <= g: rows of motions along and turns of f, columns of those of g.
  struct Products {
    Matrices move_move, move_turn, turn_move, turn_turn;
  };

  bool read(const SiteJacobian& jacobian, int point, int lane);
  void find_groups();
  bool fits(int group, int point) const;
  void multiply_half(const double* upper, int half);
  static size_t pair_of(int f, int g) { return static_cast<size_t>(g) * (g + 1) / 2 + f; }

  int points_ = 0, lanes_ = 0, groups_ = 0;
  std::vector<SiteLanes> sites_;
  std::vector<Blocks> site_blocks_, group_blocks_;  ///< [point][lane] and [group][lane]
  AlignedVector<Products> products_;                ///< by pair_of(); never fewer than before
};

}  // namespace stark
