// Four pairs of primitives at a time, tested for an axis that keeps them apart; not part of the public
// interface.
#pragma once

#include <algorithm>
#include <array>
#include <cstdint>
#include <span>
#include <vector>

#include <stark/collision/primitive_pairs.h>

namespace stark::detail {

inline constexpr int kPairs = 4;
using Double4 = double __attribute__((vector_size(32)));
using Long4 = int64_t __attribute__((vector_size(32)));

struct Vec3x4 {
  Double4 x, y, z;
};

inline Vec3x4 operator+(const Vec3x4& a, const Vec3x4& b) { return {a.x + b.x, a.y + b.y, a.z + b.z}; }
inline Vec3x4 operator-(const Vec3x4& a, const Vec3x4& b) { return {a.x - b.x, a.y - b.y, a.z - b.z}; }
inline Double4 dot(const Vec3x4& a, const Vec3x4& b) { return a.x * b.x + a.y * b.y + a.z * b.z; }
inline Vec3x4 cross(const Vec3x4& a, const Vec3x4& b) {
  return {a.y * b.z - a.z * b.y, a.z * b.x - a.x * b.z, a.x * b.y - a.y * b.x};
}
inline Double4 min(const Double4& a, const Double4& b) { return a < b ? a : b; }
inline Double4 max(const Double4& a, const Double4& b) { return a > b ? a : b; }
inline Double4 abs(const Double4& a) { return max(a, -a); }

inline int mask_of(const Long4& lanes) {
#if defined(__AVX__)
  return __builtin_ia32_movmskpd256(reinterpret_cast<Double4>(lanes));
#else
  int mask = 0;
  for (int k = 0; k < kPairs; ++k) mask |= static_cast<int>(lanes[k] & 1) << k;
  return mask;
#endif
}

// Rounding errors of a projected gap relative to the size of the differences, as in ccd.cpp.
inline constexpr double kGapError = 32.0 * 0x1p-53;

// A direction that may separate the primitives, besides the coordinate axes and the line of centres: the
// normal of a triangle, or the common normal of two edges.
template <PairKind kind, size_t count, typename Test>
void try_normal(const Vec3x4 (&x)[count], Test&& test) {
  if constexpr (kind == PairKind::PointTriangle) test(cross(x[2] - x[1], x[3] - x[1]));
  if constexpr (kind == PairKind::EdgeEdge) test(cross(x[1] - x[0], x[3] - x[2]));
}

// Lanes whose primitives one axis, or the gap between their boxes, keeps apart by more than the limit at each
// of the instants, hence, gaps of vertex pairs along an axis being linear in time, on the straight way
// between two of them. x: positions by instant and vertex.
template <PairKind kind, size_t kInstants, size_t kCount>
int find_separated(const Vec3x4 (&x)[kInstants][kCount], const Double4& limit) {
  constexpr int kA = PairRow<kind>::kFirstCount, kB = PairRow<kind>::kSecondCount;
  constexpr int kGaps = static_cast<int>(kInstants) * kA * kB;
  Vec3x4 gaps[kGaps];
  int count = 0;
  for (int i = 0; i < kA; ++i)
    for (int j = 0; j < kB; ++j)
      for (size_t t = 0; t < kInstants; ++t) gaps[count++] = x[t][i] - x[t][kA + j];
  Vec3x4 low = gaps[0], high = gaps[0], centre = gaps[0];
  for (int k = 1; k < kGaps; ++k) {
    low = {min(low.x, gaps[k].x), min(low.y, gaps[k].y), min(low.z, gaps[k].z)};
    high = {max(high.x, gaps[k].x), max(high.y, gaps[k].y), max(high.z, gaps[k].z)};
    centre = centre + gaps[k];
  }
  const Double4 size =
      max(abs(low.x), abs(high.x)) + max(abs(low.y), abs(high.y)) + max(abs(low.z), abs(high.z));
  const Double4 margin = limit + 2.0 * kGapError * size;
  // Axes have any length: the squares of gap and margin are compared.
  const Double4 margin2 = margin * margin * (1.0 + 1e-12), zero{};
  const Vec3x4 apart{max(max(low.x, -high.x), zero), max(max(low.y, -high.y), zero),
                     max(max(low.z, -high.z), zero)};
  // Comparisons drop numbers that are not finite; the sum of all gaps does not.
  const Long4 finite = 0.0 * centre.x + 0.0 * centre.y + 0.0 * centre.z == 0.0;
  Long4 separated = (dot(apart, apart) > margin2) & finite;
  if (mask_of(separated) == (1 << kPairs) - 1) return mask_of(separated);
  const auto test = [&](const Vec3x4& n) {
    Double4 smallest = dot(n, gaps[0]), largest = smallest;
    for (int k = 1; k < kGaps; ++k) {
      const Double4 gap = dot(n, gaps[k]);
      smallest = min(smallest, gap);
      largest = max(largest, gap);
    }
    const Double4 least = margin2 * dot(n, n);
    separated |= (smallest > 0.0) & (smallest * smallest > least);
    separated |= (largest < 0.0) & (largest * largest > least);
  };
  Vec3x4 middle[kCount];
  for (size_t k = 0; k < kCount; ++k) middle[k] = kInstants == 1 ? x[0][k] : x[0][k] + x[kInstants - 1][k];
  test(centre);
  try_normal<kind>(middle, test);
  return mask_of(separated & finite);
}

inline Vec3x4 gather(std::span<const Vec3> x, const std::array<int32_t, kPairs>& ids) {
  const Vec3 &a = x[ids[0]], &b = x[ids[1]], &c = x[ids[2]], &d = x[ids[3]];
  return {Double4{a.x, b.x, c.x, d.x}, Double4{a.y, b.y, c.y, d.y}, Double4{a.z, b.z, c.z, d.z}};
}

// Up to four pairs of a list with what their distances are compared with.
template <PairKind kind>
struct FourPairs {
  static constexpr int kCount = PairRow<kind>::kFirstCount + PairRow<kind>::kSecondCount;
  std::array<std::array<int32_t, kCount>, kPairs> ids;
  std::array<double, kPairs> limit;  // [m]
  int used;                          // bits of lanes

  // Pairs [first, end) of the list, at most four. limit_of(a, b): of two groups.
  template <typename Limit>
  FourPairs(const SurfaceMesh& mesh, std::span<const PrimitivePair> pairs, int64_t first, int64_t end,
            const Limit& limit_of)
      : used((1 << std::min<int64_t>(kPairs, end - first)) - 1) {
    for (int lane = 0; lane < kPairs; ++lane) {
      const PrimitivePair& pair = pairs[std::min(first + lane, end - 1)];
      const PrimitivePair groups = PairRow<kind>::groups(mesh, pair);
      ids[lane] = PairRow<kind>::vertices(mesh, pair);
      limit[lane] = limit_of(groups.first, groups.second);
    }
  }

  // Bits of the lanes that no axis separates.
  template <size_t kInstants>
  int find_open(const std::array<std::span<const Vec3>, kInstants>& x) const {
    Vec3x4 at[kInstants][kCount];
    for (size_t t = 0; t < kInstants; ++t)
      for (int i = 0; i < kCount; ++i) at[t][i] = gather(x[t], {ids[0][i], ids[1][i], ids[2][i], ids[3][i]});
    return ~find_separated<kind>(at, Double4{limit[0], limit[1], limit[2], limit[3]}) & used;
  }
};

}  // namespace stark::detail
