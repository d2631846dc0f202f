// See quadrature_plan.h.
#include <stark/mechanics/quadrature_plan.h>

#include <algorithm>
#include <cmath>

#include <stark/base/simd.h>
#include <stark/mechanics/element_projection.h>

namespace stark {

using symbolic::kLanes;
using symbolic::Order;

namespace {

constexpr int64_t kEnergyGroups = 32;  ///< groups in a partial sum of energies

/// Groups in a coloured chunk; depends on the mesh only.
int64_t chunk_groups(int64_t group_count) { return std::clamp<int64_t>(group_count / 32, 4, 32); }

/// Output `row` of the lane with number `lane`, counted over consecutive blocks.
const double& output(const double* out, int outputs, int64_t lane, int row) {
  return out[(lane / kLanes * outputs + row) * kLanes + lane % kLanes];
}

/// Row of the upper triangle of a 9x9 Hessian among the outputs.
int hessian_row(int r, int c) {
  if (r > c) std::swap(r, c);
  return 10 + r * 9 - r * (r - 1) / 2 + (c - r);
}

}  // namespace

QuadraturePlan::QuadraturePlan(const QuadratureBatch& batch, const KinematicMap& map,
                               const BlockPattern& pattern)
    : batch_(batch),
      map_(map),
      slots_(pair_slots(map, batch.stencils(), batch.node_count(), pattern)),
      colours_(colour_chunks(map, batch.stencils(), batch.node_count(),
                             kGroupElements * chunk_groups(batch.group_count()))),
      energies_(batch.size(), 0.0) {}

void QuadraturePlan::assemble(ThreadPool& pool, std::span<const Vec3> x, const Target& target) {
  for (const auto& colour : colours_)
    pool.for_each_task(static_cast<int64_t>(colour.size()),
                       [&](int64_t task, int) { assemble_chunk(colour[task], x, target); });
}

void QuadraturePlan::assemble_chunk(const Chunk& chunk, std::span<const Vec3> x, const Target& target) {
  const Potential& potential = batch_.law().potential();
  const int outputs = potential.kernel().output_count(Order::Hessian), points = batch_.points_per_element();
  thread_local AlignedVector<double> law;
  thread_local ElementStiffness stiffness;
  law.resize(static_cast<size_t>(points) * outputs * kLanes);
  stiffness.gradient.resize(batch_.node_count());
  stiffness.values.resize(static_cast<size_t>(9) * batch_.node_count() * batch_.padded_nodes());
  for (int64_t first = chunk.first; first < chunk.last; first += kGroupElements) {
    const int64_t group = first / kGroupElements;
    batch_.evaluate(Order::Hessian, x, group, group + 1, law.data());
    const int64_t blocks = batch_.block_of_group(group + 1) - batch_.block_of_group(group);
    if (target.project) target.projected_count += project_blocks(potential, blocks, law.data());
    for (int64_t e = first; e < std::min(first + kGroupElements, chunk.last); ++e) {
      const int64_t lane = (e - first) * points;
      energies_[e] = 0.0;
      for (int q = 0; q < points; ++q) energies_[e] += output(law.data(), outputs, lane + q, 0);
      compute_stiffness(e, law.data(), lane, stiffness);
      add_element(e, stiffness, target);
    }
  }
}

void QuadraturePlan::compute_stiffness(int64_t element, const double* law, int64_t first_lane,
                                       ElementStiffness& out) const {
  using simd::load, simd::splat, simd::store, simd::VDouble;
  constexpr int kWidth = simd::kWidth<double>, kMostVectors = 7;
  const int nodes = batch_.node_count(), padded = batch_.padded_nodes(), vectors = padded / kWidth;
  const int outputs = batch_.law().potential().kernel().output_count(Order::Hessian);
  std::fill(out.gradient.begin(), out.gradient.end(), Vec3{});
  std::fill(out.values.begin(), out.values.end(), 0.0);
  for (int q = 0; q < batch_.points_per_element(); ++q) {
    const double* G = batch_.gradients(element, q);
    for (int j = 0; j < 3; ++j)
      for (int i = 0; i < 3; ++i) {
        const double stress = output(law, outputs, first_lane + q, 1 + 3 * j + i);
        for (int a = 0; a < nodes; ++a) out.gradient[a][i] += stress * G[j * padded + a];
      }
  }
  // For each pair of components (i, k): W_j(b) = sum_l H_(ij)(kl) G_l(b), then K(a, b) += sum_j G_j(a)
  // W_j(b).
  for (int ik = 0; ik < 9; ++ik) {
    const int i = ik / 3, k = ik % 3;
    double* slab = out.values.data() + static_cast<int64_t>(ik) * nodes * padded;
    for (int q = 0; q < batch_.points_per_element(); ++q) {
      const double* G = batch_.gradients(element, q);
      VDouble W[3][kMostVectors];
      for (int j = 0; j < 3; ++j) {
        VDouble H[3];
        for (int l = 0; l < 3; ++l)
          H[l] = splat(output(law, outputs, first_lane + q, hessian_row(3 * j + i, 3 * l + k)));
        for (int v = 0; v < vectors; ++v)
          W[j][v] = simd::fma(H[2], load(G + 2 * padded + v * kWidth),
                              simd::fma(H[1], load(G + padded + v * kWidth), H[0] * load(G + v * kWidth)));
      }
      for (int a = 0; a < nodes; ++a) {
        const VDouble g0 = splat(G[a]), g1 = splat(G[padded + a]), g2 = splat(G[2 * padded + a]);
        for (int v = a / kWidth; v < vectors; ++v) {
          double* entry = slab + a * padded + v * kWidth;
          store(entry, simd::fma(g2, W[2][v], simd::fma(g1, W[1][v], simd::fma(g0, W[0][v], load(entry)))));
        }
      }
    }
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
  const int32_t* slots = slots_.data() + element * nodes * (nodes + 1) / 2;
  for (int a = 0; a < nodes; ++a) {
    const int32_t block_a = map_.point_block(sites[a]);
    if (block_a == kNoBlock) {
      slots += nodes - a;
      continue;
    }
    Vec3 g = stiffness.gradient[a];
    if (!target.pending.empty()) g += pending_force(stiffness, a, sites, target.pending);
    for (int c = 0; c < 3; ++c) target.gradient[3 * block_a + c] += g[c];
    for (int b = a; b < nodes; ++b, ++slots) {
      if (*slots < 0) continue;
      const double* entry = stiffness.values.data() + a * padded + b;
      double* values = target.hessian.values.data() + 9 * target.slot_of_plan[*slots];
      const bool transposed = block_a > map_.point_block(sites[b]);
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
