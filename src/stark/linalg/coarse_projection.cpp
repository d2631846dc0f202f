#include <stark/linalg/coarse_projection.h>

#include <algorithm>

#include <stark/base/simd.h>

namespace stark {

namespace {

using simd::VDouble;

// A vector's lanes as (y, z, x) and (z, x, y): a x b = yzx(a) zxy(b) - zxy(a) yzx(b).
VDouble yzx(VDouble v) { return __builtin_shufflevector(v, v, 1, 2, 0, 3); }
VDouble zxy(VDouble v) { return __builtin_shufflevector(v, v, 2, 0, 1, 3); }

// Rows of a block, three numbers and a zero each; nothing beyond the block is read.
struct Rows {
  VDouble row[3];
};
Rows load_rows(const double* a) {
  const VDouble zero = simd::splat(0.0), last = simd::load(a + 5);
  return {{__builtin_shufflevector(simd::load(a), zero, 0, 1, 2, 4),
           __builtin_shufflevector(simd::load(a + 3), zero, 0, 1, 2, 4),
           __builtin_shufflevector(last, zero, 1, 2, 3, 4)}};
}

// Forces on one block by the motions of a cluster, summed over its blocks.
struct BlockForces {
  int32_t cluster;
  VDouble by_shift[3], by_turn[3];
};

// A t + A (theta x d) of a block at the arm d: a row a of A gives a . t + (d x a) . theta.
void add_columns(const Rows& a, const Vec3& arm, BlockForces& out) {
  const VDouble d{arm[0], arm[1], arm[2], 0.0}, d_yzx = yzx(d), d_zxy = zxy(d);
  for (int r = 0; r < 3; ++r) {
    out.by_shift[r] = out.by_shift[r] + a.row[r];
    out.by_turn[r] = simd::fma(d_yzx, zxy(a.row[r]), simd::fnma(d_zxy, yzx(a.row[r]), out.by_turn[r]));
  }
}

void add_to(double* out, VDouble v) { simd::store(out, simd::load(out) + v); }

// Forces f on a block at the arm d as force and moment on its cluster: f and d x f.
void add_rows(const VDouble* f, const Vec3& d, double* out) {
  for (int r = 0; r < 3; ++r) {
    const int s = (r + 1) % 3, t = (r + 2) % 3;
    add_to(out + 8 * r, f[r]);
    add_to(out + 8 * (3 + r), simd::splat(d[s]) * f[t] - simd::splat(d[t]) * f[s]);
  }
}

CoarseBlock& block_of(int32_t cluster, ClusterRow& row) {
  for (CoarseBlock& block : row)
    if (block.cluster == cluster) return block;
  return row.emplace_back(CoarseBlock{cluster, {}});
}

}  // namespace

void project_cluster(const BlockMatrix& matrix, std::span<const int32_t> blocks, const ClusterMap& map,
                     ClusterRow& out) {
  const BlockPattern& pattern = matrix.pattern;
  out.clear();
  std::vector<BlockForces> found;
  for (const int32_t i : blocks) {
    found.clear();
    for (int64_t slot = pattern.row_start[i]; slot < pattern.row_start[i + 1]; ++slot) {
      const int32_t j = pattern.column[slot], other = map.cluster[j];
      if (other < 0) continue;
      Rows rows = load_rows(matrix.values.data() + 9 * slot);
      if (j == i)
        for (VDouble& row : rows.row) row = simd::splat(0.5) * row;
      auto at = std::ranges::find(found, other, &BlockForces::cluster);
      if (at == found.end()) at = found.insert(found.end(), BlockForces{other, {}, {}});
      add_columns(rows, map.arm[j], *at);
    }
    for (const BlockForces& forces : found) {
      CoarseBlock& block = block_of(forces.cluster, out);
      add_rows(forces.by_shift, map.arm[i], block.values.data());
      add_rows(forces.by_turn, map.arm[i], block.values.data() + 4);
    }
  }
  std::ranges::sort(out, {}, &CoarseBlock::cluster);
}

}  // namespace stark
