// See element_scatter.h.
#include <stark/mechanics/element_scatter.h>

#include <algorithm>
#include <array>
#include <ranges>

#include <stark/base/error.h>
#include <stark/base/simd.h>
#include <stark/symbolic/kernel.h>

namespace stark {

using symbolic::kLanes;

namespace {

using simd::VDouble;
constexpr int kHalf = simd::kWidth<double>;  ///< lanes transposed at once

/// Rows of four lanes become lanes of four entries.
void transpose(std::array<VDouble, 4>& v) {
  const VDouble a = __builtin_shufflevector(v[0], v[1], 0, 4, 2, 6);
  const VDouble b = __builtin_shufflevector(v[0], v[1], 1, 5, 3, 7);
  const VDouble c = __builtin_shufflevector(v[2], v[3], 0, 4, 2, 6);
  const VDouble d = __builtin_shufflevector(v[2], v[3], 1, 5, 3, 7);
  v[0] = __builtin_shufflevector(a, c, 0, 1, 4, 5);
  v[1] = __builtin_shufflevector(b, d, 0, 1, 4, 5);
  v[2] = __builtin_shufflevector(a, c, 2, 3, 6, 7);
  v[3] = __builtin_shufflevector(b, d, 2, 3, 6, 7);
}

/// Where the nine entries of block (p, q), row by row, are in the upper triangle.
std::array<int, 9> find_entries(int n, int p, int q) {
  std::array<int, 9> entries;
  for (int a = 0; a < 3; ++a)
    for (int b = 0; b < 3; ++b) {
      const int i = std::min(3 * p + a, 3 * q + b), j = std::max(3 * p + a, 3 * q + b);
      entries[3 * a + b] = i * n - i * (i - 1) / 2 + (j - i);
    }
  return entries;
}

/// Adds a block given by its first four entries, the next four and the last.
void add(double* block, VDouble first, VDouble second, double last, bool is_transposed) {
  if (is_transposed) {
    const VDouble a = first, b = second;
    first = __builtin_shufflevector(a, b, 0, 3, 6, 1);
    second = __builtin_shufflevector(a, b, 4, 7, 2, 5);
  }
  simd::store(block, simd::load(block) + first);
  simd::store(block + 4, simd::load(block + 4) + second);
  block[8] += last;
}

/// Brings the blocks of a pair into the cache while those of the pair before are added.
void prefetch(const PairPlace* places, int stride, int64_t lane_count, std::span<const int64_t> slot_of,
              const BlockMatrix& matrix) {
  for (int64_t l = 0; l < lane_count; ++l)
    if (const PairPlace place = places[l * stride]; place >= 0)
      __builtin_prefetch(matrix.values.data() + 9 * slot_of[place >> 1], 1);
}

}  // namespace

std::vector<PairPlace> find_pair_places(const KinematicMap& map, std::span<const int32_t> stencils, int nodes,
                                        const BlockPattern& pattern) {
  std::vector<PairPlace> places;
  places.reserve(stencils.size() / nodes * (nodes * (nodes + 1) / 2));
  STARK_CHECK(pattern.slot_count() < (int64_t{1} << 30));
  for (size_t first = 0; first < stencils.size(); first += nodes)
    for (int p = 0; p < nodes; ++p)
      for (int q = p; q < nodes; ++q) {
        const int32_t a = map.point_block(stencils[first + p]), b = map.point_block(stencils[first + q]);
        if (a == kNoBlock || b == kNoBlock)
          places.push_back(-1);
        else
          places.push_back(static_cast<int32_t>(2 * pattern.slot(std::min(a, b), std::max(a, b))) +
                           (a > b ? 1 : 0));
      }
  return places;
}

std::vector<int32_t> find_node_blocks(const KinematicMap& map, std::span<const int32_t> stencils) {
  std::vector<int32_t> blocks;
  blocks.reserve(stencils.size());
  for (const int32_t site : stencils) blocks.push_back(map.point_block(site));
  return blocks;
}

void scatter_gradients(const double* lanes, int nodes, int64_t lane_count, const int32_t* blocks,
                       double* padded) {
  for (int p = 0; p < nodes; ++p, lanes += 3 * kLanes)
    for (int64_t half = 0; half < lane_count; half += kHalf) {
      const auto row = [&](int k) { return simd::load(lanes + k * kLanes + half); };
      std::array<VDouble, 4> gradients{row(0), row(1), row(2), simd::splat(0.0)};
      transpose(gradients);
      for (int l = 0; l < kHalf && half + l < lane_count; ++l) {
        const int32_t block = blocks[(half + l) * nodes + p];
        if (block == kNoBlock) continue;
        double* sum = padded + 4 * static_cast<int64_t>(block);
        simd::store(sum, simd::load(sum) + gradients[l]);
      }
    }
}

void scatter_hessians(const double* upper, int nodes, int64_t lane_count, const PairPlace* places,
                      std::span<const int64_t> slot_of, BlockMatrix& matrix, ScatterPairs pairs) {
  const int pair_count = nodes * (nodes + 1) / 2;
  int pair = 0;
  for (int p = 0; p < nodes; ++p) {
    const int own = pair;  // of the node with itself
    // Both orders of two nodes that are one point belong to the block of that point.
    const auto is_one_point = [&](int64_t lane) {
      const PairPlace* of_element = places + lane * pair_count;
      return pair != own && of_element[own] >= 0 && of_element[pair] == of_element[own];
    };
    for (int q = p; q < nodes; ++q, ++pair) {
      if (q > p && pairs == ScatterPairs::Diagonal &&
          std::ranges::none_of(std::views::iota(int64_t{0}, lane_count), is_one_point))
        continue;
      const std::array<int, 9> entries = find_entries(3 * nodes, p, q);
      if (pair + 1 < pair_count) prefetch(places + pair + 1, pair_count, lane_count, slot_of, matrix);
      for (int64_t half = 0; half < lane_count; half += kHalf) {
        const auto row = [&](int k) { return simd::load(upper + entries[k] * kLanes + half); };
        std::array<VDouble, 4> first{row(0), row(1), row(2), row(3)}, second{row(4), row(5), row(6), row(7)};
        const VDouble last = row(8);
        transpose(first);
        transpose(second);
        for (int l = 0; l < kHalf && half + l < lane_count; ++l) {
          const PairPlace place = places[(half + l) * pair_count + pair];
          if (place < 0) continue;
          const bool is_one = is_one_point(half + l);
          if (q > p && pairs == ScatterPairs::Diagonal && !is_one) continue;
          double* block = matrix.values.data() + 9 * slot_of[place >> 1];
          add(block, first[l], second[l], last[l], (place & 1) != 0);
          if (is_one) add(block, first[l], second[l], last[l], true);
        }
      }
    }
  }
}

}  // namespace stark
