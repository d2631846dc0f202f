// See quadrature_plan.h.
#include <stark/mechanics/quadrature_plan.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <utility>

#include <stark/base/error.h>
#include <stark/base/simd.h>
#include <stark/mechanics/element_projection.h>
#include <stark/mechanics/lane_of.h>

namespace stark {

using symbolic::kLanes;
using symbolic::Order;

namespace {

constexpr int64_t kEnergyGroups = 32;  ///< groups in a partial sum of energies

/// Groups in a coloured chunk; depends on the mesh only.
int64_t chunk_groups(int64_t group_count) { return std::clamp<int64_t>(group_count / 32, 4, 32); }

/// For components (i, k) and directions (j, l): place of H_(ij)(kl) among the outputs of a lane. Unknown
/// 3 j + i of the law is F_ij.
constexpr std::array<int, 81> kHessianPlaces = [] {
  std::array<int, 81> places{};
  for (int n = 0; n < 81; ++n) {
    const int i = n / 27, k = n / 9 % 3, j = n / 3 % 3, l = n % 3;
    const int r = std::min(3 * j + i, 3 * l + k), c = std::max(3 * j + i, 3 * l + k);
    places[n] = (10 + r * 9 - r * (r - 1) / 2 + (c - r)) * kLanes;
  }
  return places;
}();

/// One slab of the stiffness, the components (i, k) of all pairs of nodes: with W_j(b) = sum_l H_(ij)(kl)
/// G_l(b) at each point, K(a, b) = sum_points sum_j G_j(a) W_j(b) for b >= a, four columns at a time.
template <int kVectors>
class SlabKernel {
 public:
  using V = simd::VDouble;
  static constexpr int kWidth = simd::kWidth<double>, kPadded = kVectors * kWidth;

  /// gradients: [points][3][kPadded]; H: [points][3 j][3 l]; work: [points][3][kPadded].
  static void run(const double* gradients, const double* H, int points, int nodes, double* work,
                  double* slab) {
    for (int q = 0; q < points; ++q) {
      const double* G = gradients + q * 3 * kPadded;
      for (int j = 0; j < 3; ++j) {
        const double* h = H + 9 * q + 3 * j;
        for (int v = 0; v < kPadded; v += kWidth) {
          V w = simd::splat(h[0]) * simd::load(G + v);
          w = simd::fma(simd::splat(h[1]), simd::load(G + kPadded + v), w);
          w = simd::fma(simd::splat(h[2]), simd::load(G + 2 * kPadded + v), w);
          simd::store(work + (3 * q + j) * kPadded + v, w);
        }
      }
    }
    [&]<int... kFirst>(std::integer_sequence<int, kFirst...>) {
      (rows<kFirst>(gradients, work, points, nodes, slab), ...);
    }(std::make_integer_sequence<int, kVectors>());
  }

 private:
  /// Rows 4 kFirst to 4 kFirst + 3, columns from 4 kFirst on.
  template <int kFirst>
  static void rows(const double* gradients, const double* work, int points, int nodes, double* slab) {
    constexpr int kCount = kVectors - kFirst;
    constexpr int kChains = kCount <= 3 ? 3 : 1;  // independent sums hide the latency of short rows
    for (int a = kFirst * kWidth; a < std::min(nodes, (kFirst + 1) * kWidth); ++a) {
      V sum[kChains][kCount] = {};
      for (int row = 0; row < 3 * points; row += 3)
        for (int j = 0; j < 3; ++j) {
          const V g = simd::splat(gradients[(row + j) * kPadded + a]);
          const double* w = work + (row + j) * kPadded + kFirst * kWidth;
          for (int v = 0; v < kCount; ++v)
            sum[j % kChains][v] = simd::fma(g, simd::load(w + v * kWidth), sum[j % kChains][v]);
        }
      for (int v = 0; v < kCount; ++v) {
        if constexpr (kChains == 3) sum[0][v] = sum[0][v] + sum[1][v] + sum[2][v];
        simd::store(slab + a * kPadded + (kFirst + v) * kWidth, sum[0][v]);
      }
    }
  }
};

}  // namespace

QuadraturePlan::QuadraturePlan(const QuadratureBatch& batch, const KinematicMap& map,
                               const BlockPattern& pattern)
    : batch_(batch),
      map_(map),
      places_(find_pair_places(map, batch.stencils(), batch.node_count(), pattern)),
      colours_(colour_chunks(map, batch.stencils(), batch.node_count(),
                             kGroupElements * chunk_groups(batch.group_count()))),
      energies_(batch.size(), 0.0) {
  const int padded = batch.padded_nodes();
  STARK_CHECK(padded == 4 || padded == 8 || padded == 12 || padded == 28);
}

void QuadraturePlan::assemble(ThreadPool& pool, std::span<const Vec3> x, const Target& target) {
  for (const auto& colour : colours_)
    pool.for_each_task(static_cast<int64_t>(colour.size()),
                       [&](int64_t task, int) { assemble_chunk(colour[task], x, target); });
}

void QuadraturePlan::assemble_chunk(const Chunk& chunk, std::span<const Vec3> x, const Target& target) {
  const Potential& potential = batch_.law().potential();
  const int outputs = batch_.output_count(Order::Hessian), points = batch_.points_per_element();
  thread_local AlignedVector<double> law;
  thread_local ElementStiffness stiffness;
  law.resize(static_cast<size_t>(points) * outputs * kLanes);
  stiffness.gradient.resize(static_cast<size_t>(3) * batch_.padded_nodes());
  stiffness.values.resize(static_cast<size_t>(9) * batch_.node_count() * batch_.padded_nodes());
  for (int64_t first = chunk.first; first < chunk.last; first += kGroupElements) {
    const int64_t group = first / kGroupElements;
    if (potential.is_one_sided() && !has_energy(x, group, law)) {
      std::fill(energies_.begin() + first, energies_.begin() + std::min(first + kGroupElements, chunk.last),
                0.0);
      continue;
    }
    batch_.evaluate(Order::Hessian, x, group, group + 1, law.data());
    const int64_t blocks = batch_.block_of_group(group + 1) - batch_.block_of_group(group);
    if (target.project)
      target.projected_count +=
          batch_.dilatation() ? project_blocks(10, MeanDilatation::kRow, outputs, false, blocks, law.data())
                              : project_blocks(potential, blocks, law.data());
    for (int64_t e = first; e < std::min(first + kGroupElements, chunk.last); ++e) {
      const int64_t lane = (e - first) * points;
      energies_[e] = 0.0;
      for (int q = 0; q < points; ++q) energies_[e] += *lane_of(law.data(), outputs, lane + q);
      compute_stiffness(e, law.data(), lane, stiffness);
      add_element(e, stiffness, target);
    }
  }
}

bool QuadraturePlan::has_energy(std::span<const Vec3> x, int64_t group, std::span<double> work) const {
  batch_.evaluate(Order::Energy, x, group, group + 1, work.data());
  const int64_t blocks = batch_.block_of_group(group + 1) - batch_.block_of_group(group);
  const auto energies = work.first(static_cast<size_t>(blocks * kLanes));
  return std::ranges::any_of(energies, [](double energy) { return energy != 0.0; });
}

void QuadraturePlan::compute_gradient(int64_t element, const double* law, int outputs, int64_t first_lane,
                                      std::span<double> out) const {
  const int padded = batch_.padded_nodes(), points = batch_.points_per_element();
  const double* gradients = batch_.gradients(element, 0);
  std::fill(out.begin(), out.end(), 0.0);
  for (int q = 0; q < points; ++q) {
    const double* values = lane_of(law, outputs, first_lane + q);
    for (int i = 0; i < 3; ++i)
      for (int j = 0; j < 3; ++j) {
        const double stress = values[(1 + 3 * j + i) * kLanes];
        const double* G = gradients + (3 * q + j) * padded;
        for (int a = 0; a < padded; ++a) out[i * padded + a] += stress * G[a];
      }
  }
}

void QuadraturePlan::compute_stiffness(int64_t element, const double* law, int64_t first_lane,
                                       ElementStiffness& out) const {
  const int nodes = batch_.node_count(), padded = batch_.padded_nodes(), points = batch_.points_per_element();
  const int outputs = batch_.output_count(Order::Hessian);
  const int shift = batch_.dilatation() ? (MeanDilatation::kUpper - 10) * kLanes : 0;
  const double* gradients = batch_.gradients(element, 0);
  thread_local AlignedVector<double> H, work;
  H.resize(static_cast<size_t>(81) * points);
  work.resize(static_cast<size_t>(3) * points * padded);
  compute_gradient(element, law, outputs, first_lane, out.gradient);
  for (int q = 0; q < points; ++q) {
    const double* values = lane_of(law, outputs, first_lane + q);
    for (int ik = 0; ik < 9; ++ik)
      for (int jl = 0; jl < 9; ++jl)
        H[(ik * points + q) * 9 + jl] = values[shift + kHessianPlaces[9 * ik + jl]];
  }
  for (int ik = 0; ik < 9; ++ik) {
    double* slab = out.values.data() + static_cast<int64_t>(ik) * nodes * padded;
    const double* slab_H = H.data() + static_cast<int64_t>(ik) * points * 9;
    switch (padded) {
      case 4:
        SlabKernel<1>::run(gradients, slab_H, points, nodes, work.data(), slab);
        break;
      case 8:
        SlabKernel<2>::run(gradients, slab_H, points, nodes, work.data(), slab);
        break;
      case 12:
        SlabKernel<3>::run(gradients, slab_H, points, nodes, work.data(), slab);
        break;
      default:
        SlabKernel<7>::run(gradients, slab_H, points, nodes, work.data(), slab);
    }
  }
  if (batch_.dilatation()) add_coupling(element, law, first_lane, out);
}

void QuadraturePlan::add_coupling(int64_t element, const double* law, int64_t first_lane,
                                  ElementStiffness& out) const {
  const MeanDilatation& dilatation = *batch_.dilatation();
  const int nodes = batch_.node_count(), padded = batch_.padded_nodes(), points = batch_.points_per_element();
  const int modes = dilatation.modes(), width = 3 * padded;
  thread_local AlignedVector<double> D, A;  // by mode: derivatives of its amplitude; what goes with it
  D.assign(static_cast<size_t>(modes) * width, 0.0);
  A.assign(static_cast<size_t>(modes) * width, 0.0);
  std::array<double, 16> B{};
  for (int q = 0; q < points; ++q) {
    const double* values = lane_of(law, MeanDilatation::kOutputs, first_lane + q);
    const double* shapes = dilatation.modes_at(element, q);
    for (int k = 0; k < modes; ++k) {
      const double weight = dilatation.weight(element, q) * shapes[k];
      for (int l = 0; l < modes; ++l)
        B[k * modes + l] += shapes[k] * shapes[l] * values[MeanDilatation::kRow * kLanes];
      for (int i = 0; i < 3; ++i)
        for (int j = 0; j < 3; ++j) {
          const double* G = batch_.gradients(element, q) + j * padded;
          const double d = weight * values[(MeanDilatation::kCofactors + 3 * j + i) * kLanes];
          const double a = shapes[k] * values[(MeanDilatation::kRow + 1 + 3 * j + i) * kLanes];
          for (int n = 0; n < padded; ++n) {
            D[k * width + i * padded + n] += d * G[n];
            A[k * width + i * padded + n] += a * G[n];
          }
        }
    }
  }
  for (int k = 0; k < modes; ++k)
    for (int l = 0; l < modes; ++l)
      for (int n = 0; n < width; ++n) A[k * width + n] += 0.5 * B[k * modes + l] * D[l * width + n];
  for (int k = 0; k < modes; ++k)
    for (int ij = 0; ij < 9; ++ij) {
      const double* d = D.data() + k * width;
      const double* a = A.data() + k * width;
      double* slab = out.values.data() + static_cast<int64_t>(ij) * nodes * padded;
      const int i = ij / 3 * padded, j = ij % 3 * padded;
      for (int n = 0; n < nodes; ++n)
        for (int m = n; m < padded; ++m) slab[n * padded + m] += a[i + n] * d[j + m] + d[i + n] * a[j + m];
    }
}

void QuadraturePlan::add_site_gradients(ThreadPool& pool, std::span<const Vec3> x, SiteSums& sums) {
  sums.use(batch_.stencils());
  const std::span<Vec3> gradient = sums.values();
  const int outputs = batch_.output_count(Order::Gradient);
  const int nodes = batch_.node_count(), padded = batch_.padded_nodes(), points = batch_.points_per_element();
  AlignedVector<double> law(static_cast<size_t>(batch_.law().block_count()) * outputs * kLanes);
  pool.for_each_range(batch_.group_count(), kEnergyGroups, [&](int64_t first, int64_t last) {
    batch_.evaluate(Order::Gradient, x, first, last,
                    law.data() + batch_.block_of_group(first) * outputs * kLanes);
  });
  std::vector<double> element(static_cast<size_t>(3) * padded);
  for (int64_t e = 0; e < batch_.size(); ++e) {
    const int64_t lane = batch_.block_of_group(e / kGroupElements) * kLanes + e % kGroupElements * points;
    energies_[e] = 0.0;
    for (int q = 0; q < points; ++q) energies_[e] += *lane_of(law.data(), outputs, lane + q);
    compute_gradient(e, law.data(), outputs, lane, element);
    for (int a = 0; a < nodes; ++a)
      gradient[batch_.stencil(e)[a]] += Vec3{element[a], element[padded + a], element[2 * padded + a]};
  }
}

Vec3 QuadraturePlan::pending_force(const ElementStiffness& stiffness, int a, std::span<const int32_t> nodes,
                                   std::span<const Vec3> pending) const {
  const int count = batch_.node_count(), padded = batch_.padded_nodes();
  Vec3 force;
  for (int b = 0; b < count; ++b) {
    if (!map_.is_prescribed(nodes[b])) continue;
    const Vec3& d = pending[nodes[b]];
    for (int i = 0; i < 3; ++i)
      for (int k = 0; k < 3; ++k) {
        const int64_t entry = a <= b ? static_cast<int64_t>(3 * i + k) * count * padded + a * padded + b
                                     : static_cast<int64_t>(3 * k + i) * count * padded + b * padded + a;
        force[i] += stiffness.values[entry] * d[k];
      }
  }
  return force;
}

void QuadraturePlan::add_element(int64_t element, const ElementStiffness& stiffness,
                                 const Target& target) const {
  const int nodes = batch_.node_count(), padded = batch_.padded_nodes();
  const int64_t slab = static_cast<int64_t>(nodes) * padded;
  const auto sites = batch_.stencil(element);
  const PairPlace* place = places_.data() + element * nodes * (nodes + 1) / 2;
  for (int a = 0; a < nodes; ++a) {
    const int32_t block_a = map_.point_block(sites[a]);
    if (block_a == kNoBlock) {
      place += nodes - a;
      continue;
    }
    Vec3 g{stiffness.gradient[a], stiffness.gradient[padded + a], stiffness.gradient[2 * padded + a]};
    if (!target.pending.empty()) g += pending_force(stiffness, a, sites, target.pending);
    for (int c = 0; c < 3; ++c) target.gradient[3 * block_a + c] += g[c];
    for (int b = a; b < nodes; ++b, ++place) {
      if (*place < 0) continue;
      const double* entry = stiffness.values.data() + a * padded + b;
      double* values = target.hessian.values.data() + 9 * target.slot_of_plan[*place >> 1];
      const bool transposed = (*place & 1) != 0;
      for (int i = 0; i < 3; ++i)
        for (int k = 0; k < 3; ++k) values[transposed ? 3 * k + i : 3 * i + k] += entry[(3 * i + k) * slab];
    }
  }
}

EnergyDifference QuadraturePlan::energy_difference(ThreadPool& pool, std::span<const Vec3> x) const {
  const int points = batch_.points_per_element();
  std::vector<EnergyDifference> partial((batch_.group_count() + kEnergyGroups - 1) / kEnergyGroups);
  pool.for_each_range(batch_.group_count(), kEnergyGroups, [&](int64_t first, int64_t last) {
    thread_local AlignedVector<double> energies;
    energies.resize((batch_.block_of_group(last) - batch_.block_of_group(first)) * kLanes);
    batch_.evaluate(Order::Energy, x, first, last, energies.data());
    EnergyDifference& sum = partial[first / kEnergyGroups];
    const int64_t begin = first * kGroupElements, end = std::min(last * kGroupElements, batch_.size());
    for (int64_t e = begin; e < end; ++e) {
      double energy = 0.0;
      for (int q = 0; q < points; ++q) energy += energies[(e - begin) * points + q];
      sum.difference += energy - energies_[e];
      sum.magnitude += std::fabs(energies_[e]);
    }
  });
  EnergyDifference total;
  for (const EnergyDifference& p : partial) {
    total.difference += p.difference;
    total.magnitude += p.magnitude;
  }
  return total;
}

}  // namespace stark
