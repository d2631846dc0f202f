// See lane_congruence.h.
#include <stark/mechanics/lane_congruence.h>

#include <algorithm>

#include <stark/base/simd.h>

namespace stark {

namespace {

using simd::VDouble;
constexpr int kHalf = simd::kWidth<double>;  ///< lanes multiplied at once
constexpr int kLaneCount = symbolic::kLanes;
constexpr int kHalfSize = 9 * kHalf;  ///< numbers of the matrices of half of the lanes

/// A 3x3 matrix of each lane.
using MatLanes = std::array<VDouble, 9>;
using VecLanes = std::array<VDouble, 3>;

/// Block (p, q) of the upper triangle of n x n.
MatLanes load_block(const double* upper, int n, int p, int q) {
  MatLanes H;
  for (int a = 0; a < 3; ++a)
    for (int b = 0; b < 3; ++b) {
      const int i = std::min(3 * p + a, 3 * q + b), j = std::max(3 * p + a, 3 * q + b);
      H[3 * a + b] = simd::load(upper + (i * n - i * (i - 1) / 2 + (j - i)) * kLaneCount);
    }
  return H;
}

/// sum += weight H
void add_weighted(MatLanes& sum, VDouble weight, const MatLanes& H) {
  for (int k = 0; k < 9; ++k) sum[k] = simd::fma(weight, H[k], sum[k]);
}

/// sum += H J, J = -[r]x: rows h of H become r x h.
void add_turned_columns(MatLanes& sum, const MatLanes& H, const VecLanes& r) {
  for (int i = 0; i < 3; ++i)
    for (int j = 0; j < 3; ++j) {
      const int k = (j + 1) % 3, l = (j + 2) % 3;
      const VDouble first = simd::fma(r[k], H[3 * i + l], sum[3 * i + j]);
      sum[3 * i + j] = simd::fnma(r[l], H[3 * i + k], first);
    }
}

/// sum += J^T H: columns h of H become r x h.
void add_turned_rows(double* sum, const VecLanes& r, const MatLanes& H) {
  for (int i = 0; i < 3; ++i)
    for (int j = 0; j < 3; ++j) {
      const int k = (i + 1) % 3, l = (i + 2) % 3;
      double* at = sum + (3 * i + j) * kHalf;
      const VDouble first = simd::fma(r[k], H[3 * l + j], simd::load(at));
      simd::store(at, simd::fnma(r[l], H[3 * k + j], first));
    }
}

void add_weighted(double* sum, VDouble weight, const MatLanes& H) {
  for (int k = 0; k < 9; ++k)
    simd::store(sum + k * kHalf, simd::fma(weight, H[k], simd::load(sum + k * kHalf)));
}

/// Adds a matrix of one lane, or its transpose, to the block that the matrix holds for a and b.
void add_block(BlockMatrix& hessian, int32_t a, int32_t b, const double* lane, bool is_transposed) {
  double* values = hessian.values.data() + 9 * hessian.pattern.slot(std::min(a, b), std::max(a, b));
  for (int i = 0; i < 3; ++i)
    for (int j = 0; j < 3; ++j) values[is_transposed ? 3 * j + i : 3 * i + j] += lane[(3 * i + j) * kHalf];
}

}  // namespace

bool LaneCongruence::Blocks::admits(const Blocks& other) const {
  const auto agree = [](int32_t a, int32_t b) { return a == kNoBlock || b == kNoBlock || a == b; };
  const bool is_bare = move == kNoBlock && turn == kNoBlock;
  const bool other_is_bare = other.move == kNoBlock && other.turn == kNoBlock;
  const bool shares = (move == other.move && move != kNoBlock) || (turn == other.turn && turn != kNoBlock);
  return agree(move, other.move) && agree(turn, other.turn) && (is_bare || other_is_bare || shares);
}

bool LaneCongruence::begin(std::span<const SiteJacobian> jacobians, int points, int lane_count) {
  points_ = points;
  lanes_ = lane_count;
  sites_.assign(points, {});
  site_blocks_.assign(static_cast<size_t>(points) * kLanes, {});
  for (int lane = 0; lane < lane_count; ++lane)
    for (int p = 0; p < points; ++p)
      if (!read(jacobians[static_cast<size_t>(lane) * points + p], p, lane)) return false;
  find_groups();
  if (const size_t pairs = pair_of(0, groups_); products_.size() < pairs) products_.resize(pairs);
  return true;
}

bool LaneCongruence::read(const SiteJacobian& jacobian, int point, int lane) {
  if (jacobian.is_embedded()) return false;
  SiteLanes& site = sites_[point];
  Blocks& blocks = site_blocks_[static_cast<size_t>(point) * kLanes + lane];
  for (int k = 0; k < jacobian.term_count; ++k) {
    const JacobianTerm& term = jacobian.terms[k];
    int32_t& block = term.is_rotation ? blocks.turn : blocks.move;
    if (block != kNoBlock) return false;
    block = term.block;
    if (term.is_rotation) {
      for (int c = 0; c < 3; ++c) site.lever[c][lane] = jacobian.lever[c];
      site.turns = true;
    } else {
      site.weight[lane] = term.weight;
      site.moves = true;
    }
  }
  return true;
}

bool LaneCongruence::fits(int group, int point) const {
  for (int lane = 0; lane < lanes_; ++lane)
    if (!group_blocks_[static_cast<size_t>(group) * kLanes + lane].admits(
            site_blocks_[static_cast<size_t>(point) * kLanes + lane]))
      return false;
  return true;
}

void LaneCongruence::find_groups() {
  groups_ = 0;
  group_blocks_.clear();
  for (int p = 0; p < points_; ++p) {
    int g = 0;
    while (g < groups_ && !fits(g, p)) ++g;
    if (g == groups_) {
      ++groups_;
      group_blocks_.resize(static_cast<size_t>(groups_) * kLanes);
    }
    sites_[p].group = g;
    for (int lane = 0; lane < lanes_; ++lane) {
      Blocks& group = group_blocks_[static_cast<size_t>(g) * kLanes + lane];
      const Blocks& site = site_blocks_[static_cast<size_t>(p) * kLanes + lane];
      if (site.move != kNoBlock) group.move = site.move;
      if (site.turn != kNoBlock) group.turn = site.turn;
    }
  }
}

void LaneCongruence::multiply(const double* upper) {
  for (int half = 0; half < lanes_; half += kHalf) multiply_half(upper + half, half);
}

void LaneCongruence::multiply_half(const double* upper, int half) {
  const int start = half / kHalf * kHalfSize;
  for (size_t pair = 0; pair < pair_of(0, groups_); ++pair) {
    Products& of_pair = products_[pair];
    for (Matrices* m : {&of_pair.move_move, &of_pair.move_turn, &of_pair.turn_move, &of_pair.turn_turn})
      std::fill_n(m->begin() + start, kHalfSize, 0.0);
  }
  const auto lever_of = [&](const SiteLanes& site) {
    return VecLanes{simd::load(&site.lever[0][half]), simd::load(&site.lever[1][half]),
                    simd::load(&site.lever[2][half])};
  };
  for (int p = 0; p < points_; ++p) {
    const SiteLanes& row = sites_[p];
    if (!row.moves && !row.turns) continue;
    const VDouble weight = simd::load(&row.weight[half]);
    const VecLanes lever = lever_of(row);
    for (int g = row.group; g < groups_; ++g) {
      MatLanes along{}, turned{};  // H_p J, summed over the sites of the group
      bool any_moves = false, any_turns = false;
      for (int q = 0; q < points_; ++q) {
        const SiteLanes& column = sites_[q];
        if (column.group != g || (!column.moves && !column.turns)) continue;
        const MatLanes H = load_block(upper, 3 * points_, p, q);
        if (column.moves) add_weighted(along, simd::load(&column.weight[half]), H);
        if (column.turns) add_turned_columns(turned, H, lever_of(column));
        any_moves = any_moves || column.moves;
        any_turns = any_turns || column.turns;
      }
      Products& out = products_[pair_of(row.group, g)];
      if (row.moves && any_moves) add_weighted(out.move_move.data() + start, weight, along);
      if (row.moves && any_turns) add_weighted(out.move_turn.data() + start, weight, turned);
      if (row.turns && any_moves && g > row.group)
        add_turned_rows(out.turn_move.data() + start, lever, along);
      if (row.turns && any_turns) add_turned_rows(out.turn_turn.data() + start, lever, turned);
    }
  }
}

void LaneCongruence::scatter(int lane, BlockMatrix& hessian, ScatterPairs which) const {
  const auto add = [&](int32_t a, int32_t b, const Matrices& product, bool is_once) {
    if (a == kNoBlock || b == kNoBlock || (which == ScatterPairs::Diagonal && a != b)) return;
    const double* values = product.data() + lane / kHalf * kHalfSize + lane % kHalf;
    add_block(hessian, a, b, values, a > b);
    if (a == b && !is_once) add_block(hessian, a, a, values, true);  // both orders of two groups
  };
  for (int f = 0; f < groups_; ++f) {
    const Blocks& rows = group_blocks_[static_cast<size_t>(f) * kLanes + lane];
    for (int g = f; g < groups_; ++g) {
      const Blocks& columns = group_blocks_[static_cast<size_t>(g) * kLanes + lane];
      const Products& product = products_[pair_of(f, g)];
      const bool is_once = f == g;
      add(rows.move, columns.move, product.move_move, is_once);
      add(rows.move, columns.turn, product.move_turn, is_once);
      if (f < g) add(rows.turn, columns.move, product.turn_move, is_once);
      add(rows.turn, columns.turn, product.turn_turn, is_once);
    }
  }
}

}  // namespace stark
