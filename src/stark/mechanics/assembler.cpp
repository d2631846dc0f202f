#include <stark/mechanics/assembler.h>

#include <algorithm>

#include <stark/base/error.h>
#include <stark/base/psd.h>
#include <stark/mechanics/congruence.h>
#include <stark/mechanics/element_projection.h>

namespace stark {

using symbolic::kLanes;
using symbolic::Order;

namespace {

constexpr int64_t kChunkBlocks = 32;  ///< blocks of lanes in a task: 256 elements
constexpr int64_t kGroupBlocks =
    PotentialBatch::kGroupBlocks;  ///< blocks whose Hessians are kept in cache together

/// Blocks whose gradients are kept together: a part of large batches, which then need no memory of their
/// size.
constexpr int64_t kWindowBlocks = 1024;

/// Blocks of lanes in a coloured chunk. Large chunks reuse the rows of the matrix while they are in cache;
/// small meshes get smaller ones, so that there are some for each thread. Depends on the mesh only.
int64_t coloured_chunk_blocks(int64_t block_count) {
  return std::clamp<int64_t>(block_count / 32, kChunkBlocks, 8 * kChunkBlocks);
}

int64_t lanes_used(const PotentialBatch& batch, int64_t block) {
  return std::min<int64_t>(kLanes, batch.size() - block * kLanes);
}

void add_block(BlockMatrix& hessian, int64_t slot, const Mat3& H) {
  double* values = hessian.values.data() + 9 * slot;
  for (int c = 0; c < 9; ++c) values[c] += H.m[c];
}

/// Adds gradients by sites to those by unknowns.
void add_mapped(const KinematicMap& map, const Configuration& configuration, const SiteSums& by_site,
                std::span<double> out) {
  by_site.for_each([&](int32_t i, const Vec3& gradient) {
    if (gradient != Vec3{} && !map.is_prescribed(i))  // of fine rigid meshes hardly any is pushed
      add_mapped_gradient(map.jacobian(i, configuration), gradient, out);
  });
}

}  // namespace

Assembler::Assembler(const KinematicMap& map, ThreadPool& pool) : map_(map), pool_(pool) {
  body_moment_.resize(map.layout().body_block.size());
  set_static_batches({});
}

void Assembler::append_pairs(std::span<const int32_t> stencils, int nodes,
                             std::vector<std::pair<int32_t, int32_t>>& out) const {
  std::vector<int32_t> blocks, before;
  blocks.reserve(2 * nodes);
  SupportPairs of_supports(map_);
  for (size_t first = 0; first < stencils.size(); first += nodes) {
    const auto stencil = stencils.subspan(first, nodes);
    if (std::ranges::any_of(stencil, [&](int32_t site) { return map_.is_embedded(site); })) {
      of_supports.add(stencil);
      continue;
    }
    blocks.clear();
    for (const int32_t site : stencil) map_.append_blocks(site, blocks);
    // Many sites are of one rigid body, and many contacts of the same two.
    std::ranges::sort(blocks);
    const auto doubles = std::ranges::unique(blocks);
    blocks.erase(doubles.begin(), doubles.end());
    if (blocks == before) continue;
    before = blocks;
    for (size_t a = 0; a < blocks.size(); ++a)
      for (size_t b = a + 1; b < blocks.size(); ++b) out.emplace_back(blocks[a], blocks[b]);
  }
  of_supports.append_to(out);
}

void Assembler::set_static_batches(const std::vector<PotentialBatch*>& batches,
                                   const std::vector<const QuadratureBatch*>& quadrature) {
  std::vector<std::pair<int32_t, int32_t>> pairs;
  const DofLayout& layout = map_.layout();
  for (size_t b = 0; b < layout.body_block.size(); ++b)
    if (layout.body_block[b] != kNoBlock && layout.rotation_block[b] != kNoBlock)
      pairs.emplace_back(layout.body_block[b], layout.rotation_block[b]);
  for (const PotentialBatch* batch : batches) append_pairs(batch->stencils(), batch->point_count(), pairs);
  for (const QuadratureBatch* batch : quadrature) append_pairs(batch->stencils(), batch->node_count(), pairs);
  static_pattern_ = BlockPattern::from_pairs(map_.layout().block_count, std::move(pairs));
  pattern_ = {};
  static_plans_.clear();
  quadrature_plans_.clear();
  for (PotentialBatch* batch : batches) static_plans_.push_back(plan(*batch));
  for (const QuadratureBatch* batch : quadrature)
    quadrature_plans_.emplace_back(*batch, map_, static_pattern_);
  set_dynamic_batches({});
}

Assembler::StaticPlan Assembler::plan(PotentialBatch& batch) const {
  StaticPlan plan;
  plan.batch = &batch;
  const auto stencils = batch.stencils();
  plan.is_plain = std::all_of(stencils.begin(), stencils.end(), [&](int32_t s) { return map_.is_point(s); });
  plan.energies.resize(batch.block_count() * kLanes);
  if (!plan.is_plain) return plan;
  plan.blocks = find_node_blocks(map_, stencils);
  plan.places = find_pair_places(map_, stencils, batch.point_count(), static_pattern_);
  plan.colours =
      colour_chunks(map_, stencils, batch.point_count(), kLanes * coloured_chunk_blocks(batch.block_count()));
  return plan;
}

void Assembler::set_dynamic_batches(std::vector<const PotentialBatch*> batches) {
  dynamic_batches_ = std::move(batches);
  std::vector<std::pair<int32_t, int32_t>> pairs;
  pairs.reserve(dynamic_pairs_.size());
  for (const PotentialBatch* batch : dynamic_batches_)
    append_pairs(batch->stencils(), batch->point_count(), pairs);
  if (pairs == dynamic_pairs_ && pattern_.block_count == static_pattern_.block_count) return;
  pattern_ = static_pattern_.merged_with(pairs, slot_of_static_);
  dynamic_pairs_ = std::move(pairs);
}

void Assembler::assemble(const Configuration& configuration, std::span<const Vec3> x,
                         const AssemblyOptions& options, std::span<double> out_gradient,
                         BlockMatrix& out_hessian) {
  if (out_hessian.pattern != pattern_) out_hessian.pattern = pattern_;
  out_hessian.set_zero(pool_);
  std::fill(out_gradient.begin(), out_gradient.end(), 0.0);
  std::fill(body_moment_.begin(), body_moment_.end(), Mat3{});
  projected_count_ = 0;
  padded_gradient_.assign(4 * static_cast<size_t>(pattern_.block_count), 0.0);
  low_rank_.clear();
  for (StaticPlan& plan : static_plans_) {
    plan.batch->touch(x);
    if (plan.is_plain)
      assemble_plain(plan, x, options, out_gradient, out_hessian);
    else
      assemble_mapped(*plan.batch, configuration, x, options, out_gradient, out_hessian,
                      plan.energies.data());
    if (plan.batch->potential().totals()) add_low_rank(*plan.batch, configuration, x, options, out_gradient);
  }
  for (QuadraturePlan& plan : quadrature_plans_)
    plan.assemble(pool_, x,
                  {.project = options.project,
                   .pending = options.pending,
                   .slot_of_plan = slot_of_static_,
                   .gradient = out_gradient,
                   .hessian = out_hessian,
                   .projected_count = projected_count_});
  for (int32_t b = 0; b < pattern_.block_count; ++b)
    for (int a = 0; a < 3; ++a) out_gradient[3 * b + a] += padded_gradient_[4 * b + a];
  for (const PotentialBatch* batch : dynamic_batches_)
    assemble_mapped(*batch, configuration, x, options, out_gradient, out_hessian, nullptr);
  site_pairs_.scatter(map_, configuration, out_hessian);
  add_rigid_curvature(options, out_hessian);
}

void Assembler::assemble_gradient(const Configuration& configuration, std::span<const Vec3> x,
                                  std::span<double> out_gradient) {
  site_gradient_.begin(x.size());
  for (StaticPlan& plan : static_plans_) {
    plan.batch->touch(x);
    add_site_gradients(*plan.batch, x, plan.energies.data());
  }
  for (QuadraturePlan& plan : quadrature_plans_) plan.add_site_gradients(pool_, x, site_gradient_);
  for (const PotentialBatch* batch : dynamic_batches_) add_site_gradients(*batch, x, nullptr);
  std::fill(out_gradient.begin(), out_gradient.end(), 0.0);
  add_mapped(map_, configuration, site_gradient_, out_gradient);
}

void Assembler::add_site_gradients(const PotentialBatch& batch, std::span<const Vec3> x,
                                   double* out_energies) {
  const int points = batch.point_count();
  const int64_t outputs = batch.potential().kernel().output_count(Order::Gradient);
  site_gradient_.use(batch.stencils());
  const std::span<Vec3> gradient = site_gradient_.values();
  for (int64_t begin = 0; begin < batch.block_count(); begin += kWindowBlocks) {
    const int64_t end = std::min(begin + kWindowBlocks, batch.block_count());
    double* const lanes = buffer_.reserve((end - begin) * outputs * kLanes);
    pool_.for_each_range(end - begin, kGroupBlocks, [&](int64_t first, int64_t last) {
      batch.evaluate(Order::Gradient, x, begin + first, begin + last, lanes + first * outputs * kLanes);
    });
    for (int64_t e = begin * kLanes; e < std::min(end * kLanes, batch.size()); ++e) {
      const ElementView element(lanes + (e / kLanes - begin) * outputs * kLanes, 3 * points,
                                static_cast<int>(e % kLanes));
      const auto sites = batch.stencil(e);
      if (out_energies) out_energies[e] = element.energy();
      for (int p = 0; p < points; ++p) gradient[sites[p]] += element.point_gradient(p);
    }
  }
}

void Assembler::assemble_plain(StaticPlan& plan, std::span<const Vec3> x, const AssemblyOptions& options,
                               std::span<double> gradient, BlockMatrix& hessian) {
  for (const auto& colour : plan.colours)
    pool_.for_each_task(static_cast<int64_t>(colour.size()), [&](int64_t task, int) {
      assemble_chunk(plan, colour[task], x, options, gradient, hessian);
    });
}

void Assembler::assemble_chunk(StaticPlan& plan, const Chunk& chunk, std::span<const Vec3> x,
                               const AssemblyOptions& options, std::span<double> gradient,
                               BlockMatrix& hessian) {
  const PotentialBatch& batch = *plan.batch;
  const int points = batch.point_count(), pairs = points * (points + 1) / 2;
  const int outputs = batch.potential().kernel().output_count(Order::Hessian);
  thread_local ScratchBuffer<double> buffer;
  double* const out = buffer.reserve(kGroupBlocks * outputs * kLanes);
  const int64_t last_block = (chunk.last + kLanes - 1) / kLanes;
  for (int64_t group = chunk.first / kLanes; group < last_block; group += kGroupBlocks) {
    const int64_t group_end = std::min(group + kGroupBlocks, last_block);
    const auto active = batch.evaluate_active(Order::Hessian, x, group, group_end, out);
    if (options.project) projected_count_ += project_blocks(batch.potential(), active.count, out);
    std::fill(plan.energies.begin() + group * kLanes, plan.energies.begin() + group_end * kLanes, 0.0);
    for (int k = 0; k < active.count; ++k) {
      const int64_t block = active.blocks[k];
      const double* lanes = out + k * outputs * kLanes;
      const int64_t first = block * kLanes, count = lanes_used(batch, block);
      std::copy_n(lanes, count, plan.energies.data() + first);
      scatter_gradients(lanes + kLanes, points, count, plan.blocks.data() + first * points,
                        padded_gradient_.data());
      if (!options.pending.empty()) add_pending(plan, block, lanes, options.pending, gradient);
      scatter_hessians(lanes + (1 + 3 * points) * kLanes, points, count, plan.places.data() + first * pairs,
                       slot_of_static_, hessian, options.pairs);
    }
  }
}

void Assembler::add_pending(const StaticPlan& plan, int64_t block, const double* lanes,
                            std::span<const Vec3> pending, std::span<double> gradient) const {
  const PotentialBatch& batch = *plan.batch;
  const int points = batch.point_count();
  thread_local std::vector<Vec3> extra;
  extra.assign(points, Vec3{});
  for (int64_t l = 0; l < lanes_used(batch, block); ++l) {
    const int64_t e = block * kLanes + l;
    pending_gradient(ElementView(lanes, 3 * points, static_cast<int>(l)), batch.stencil(e), map_, pending,
                     extra);
    for (int p = 0; p < points; ++p) {
      const int32_t a = plan.blocks[e * points + p];
      if (a == kNoBlock) continue;
      for (int c = 0; c < 3; ++c) gradient[3 * a + c] += extra[p][c];
    }
  }
}

void Assembler::assemble_mapped(const PotentialBatch& batch, const Configuration& configuration,
                                std::span<const Vec3> x, const AssemblyOptions& options,
                                std::span<double> gradient, BlockMatrix& hessian, double* out_energies) {
  const int points = batch.point_count();
  const int outputs = batch.potential().kernel().output_count(Order::Hessian);
  double* const lanes = buffer_.reserve(batch.block_count() * outputs * kLanes);
  pool_.for_each_range(batch.block_count(), kGroupBlocks, [&](int64_t first, int64_t last) {
    double* out = lanes + first * outputs * kLanes;
    batch.evaluate(Order::Hessian, x, first, last, out);
    if (options.project) projected_count_ += project_blocks(batch.potential(), last - first, out);
  });
  const bool are_wanted = out_energies != nullptr;
  if (!are_wanted && options.pending.empty() && point_scatter_.take(batch, map_, pool_)) {
    point_scatter_.add(batch, lanes, pool_, gradient, hessian);
    return;
  }
  for (int64_t block = 0; block < batch.block_count(); ++block) {
    const double* out = lanes + block * outputs * kLanes;
    for (int64_t l = 0; are_wanted && l < lanes_used(batch, block); ++l)
      out_energies[block * kLanes + l] = ElementView(out, 3 * points, static_cast<int>(l)).energy();
    if (!batch.rests(block)) add_mapped_block(batch, block, out, configuration, options, gradient, hessian);
  }
}

bool Assembler::find_point_blocks(std::span<const int32_t> sites) {
  bool only_points = true;
  blocks_.resize(sites.size());
  for (size_t p = 0; p < sites.size(); ++p) {
    const bool is_prescribed = map_.is_prescribed(sites[p]);
    blocks_[p] = is_prescribed || !map_.is_point(sites[p]) ? kNoBlock : map_.point_block(sites[p]);
    only_points = only_points && (is_prescribed || map_.is_point(sites[p]));
  }
  return only_points;
}

void Assembler::add_mapped_block(const PotentialBatch& batch, int64_t block, const double* out,
                                 const Configuration& configuration, const AssemblyOptions& options,
                                 std::span<double> gradient, BlockMatrix& hessian) {
  const int points = batch.point_count(), n = 3 * points;
  std::array<int, kLanes> mapped{};  // lanes of elements with other sites than points
  int mapped_count = 0;
  jacobians_.resize(static_cast<size_t>(kLanes) * points);
  const auto jacobians_of = [&](int lane) {
    return std::span(jacobians_).subspan(static_cast<size_t>(lane) * points, points);
  };
  extra_.resize(options.pending.empty() ? 0 : points);
  for (int lane = 0; lane < lanes_used(batch, block); ++lane) {
    const ElementView element(out, n, lane);
    const auto sites = batch.stencil(block * kLanes + lane);
    if (!options.pending.empty()) pending_gradient(element, sites, map_, options.pending, extra_);
    if (find_point_blocks(sites)) {
      std::ranges::fill(jacobians_of(lane), SiteJacobian{});
      add_point_element(element, blocks_, extra_, RowRange{}, gradient, hessian);
      continue;
    }
    mapped[mapped_count++] = lane;
    for (int p = 0; p < points; ++p) jacobians_of(lane)[p] = map_.jacobian(sites[p], configuration);
    add_mapped_gradients(element, jacobians_of(lane), extra_, gradient, body_moment_);
  }
  if (mapped_count == 0) return;
  const int last = mapped[mapped_count - 1] + 1;
  const bool fits = congruence_.begin(jacobians_, points, last);
  if (fits) congruence_.multiply(out + (1 + n) * kLanes);
  for (int k = 0; k < mapped_count; ++k) {
    const int lane = mapped[k];
    if (fits)
      congruence_.scatter(lane, hessian, options.pairs);
    else
      add_mapped_hessian(ElementView(out, n, lane), batch.stencil(block * kLanes + lane), jacobians_of(lane),
                         hessian, site_pairs_);
  }
}

void Assembler::add_low_rank(const PotentialBatch& batch, const Configuration& configuration,
                             std::span<const Vec3> x, const AssemblyOptions& options,
                             std::span<double> gradient) {
  const TouchingPlane& plane = batch.plane();
  const size_t m = plane.totals.size();
  std::vector<std::vector<double>> columns(m);
  std::vector<double> pending(m, 0.0);
  for (size_t k = 0; k < m; ++k) {
    site_gradient_.begin(x.size());
    site_gradient_.use(batch.stencils());
    batch.add_total_gradient(static_cast<int>(k), x, site_gradient_.values());
    columns[k].assign(gradient.size(), 0.0);
    add_mapped(map_, configuration, site_gradient_, columns[k]);
    for (size_t i = 0; i < options.pending.size(); ++i)
      pending[k] += dot(site_gradient_.values()[i], options.pending[i]);
  }
  for (size_t k = 0; k < m; ++k)
    for (size_t l = 0; l < m; ++l)
      if (const double factor = plane.curvature[k * m + l] * pending[l]; factor != 0.0)
        for (size_t i = 0; i < gradient.size(); ++i) gradient[i] += factor * columns[k][i];
  low_rank_.add(columns, plane.curvature, options.project);
}

void Assembler::add_rigid_curvature(const AssemblyOptions& options, BlockMatrix& hessian) const {
  for (size_t b = 0; b < body_moment_.size(); ++b) {
    const int32_t block = map_.layout().rotation_block[b];
    if (block == kNoBlock) continue;
    const Mat3& M = body_moment_[b];
    Mat3 K = (M + transpose(M)) * 0.5 - Mat3::identity() * trace(M);
    if (options.project) K = psd_project(K);
    add_block(hessian, hessian.pattern.slot(block, block), K);
  }
}

EnergyDifference Assembler::static_energy_difference(std::span<const Vec3> x) {
  EnergyDifference total;
  std::vector<EnergyDifference> partial;
  for (const StaticPlan& plan : static_plans_) {
    if (plan.batch->potential().totals()) {
      const EnergyDifference p = plan.batch->change_of_totals(x);
      total.difference += p.difference;
      total.magnitude += p.magnitude;
      continue;
    }
    const int64_t blocks = plan.batch->block_count();
    partial.assign((blocks + kChunkBlocks - 1) / kChunkBlocks, {});
    pool_.for_each_range(blocks, kChunkBlocks, [&](int64_t first, int64_t last) {
      thread_local ScratchBuffer<double> buffer;
      double* const energies = buffer.reserve((last - first) * kLanes);
      plan.batch->evaluate(Order::Energy, x, first, last, energies);
      EnergyDifference& sum = partial[first / kChunkBlocks];
      const int64_t begin = first * kLanes, end = std::min(last * kLanes, plan.batch->size());
      for (int64_t e = begin; e < end; ++e) {
        sum.difference += energies[e - begin] - plan.energies[e];
        sum.magnitude += std::fabs(plan.energies[e]);
      }
    });
    for (const EnergyDifference& p : partial) {
      total.difference += p.difference;
      total.magnitude += p.magnitude;
    }
  }
  for (const QuadraturePlan& plan : quadrature_plans_) {
    const EnergyDifference p = plan.energy_difference(pool_, x);
    total.difference += p.difference;
    total.magnitude += p.magnitude;
  }
  return total;
}

double Assembler::static_energy(size_t batch) const {
  const StaticPlan& plan = static_plans_[batch];
  double sum = 0.0;
  for (int64_t e = 0; e < plan.batch->size(); ++e) sum += plan.energies[e];
  return sum;
}

}  // namespace stark
