// See embedded_assembly.h.
#include <stark/mechanics/embedded_assembly.h>

#include <algorithm>
#include <tuple>
#include <utility>

namespace stark {

namespace {

constexpr size_t kMatSize = 9;

/// Sites that the same blocks move: those of a cell, of a body, or one alone.
using Group = std::pair<SiteKind, int32_t>;

Group group_of(const KinematicMap& map, int32_t site) {
  const Site& of_site = map.site(site);
  const bool is_of_body = of_site.kind == SiteKind::RigidPoint || of_site.kind == SiteKind::RigidDirection;
  return {of_site.kind, map.is_embedded(site) ? map.support_index(site) : is_of_body ? of_site.index : site};
}

/// Blocks that move a site: the same ones in the same order for all sites of a group.
std::vector<int32_t> moving_blocks(const SiteJacobian& jacobian) {
  std::vector<int32_t> blocks(jacobian.support_blocks.begin(), jacobian.support_blocks.end());
  for (int k = 0; k < jacobian.term_count; ++k) blocks.push_back(jacobian.terms[k].block);
  return blocks;
}

void add_weighted(std::span<double> sum, double weight, std::span<const double> values) {
  for (size_t k = 0; k < sum.size(); ++k) sum[k] += weight * values[k];
}

/// Sum of J_p^T H_pq J_q of the pairs of two groups of sites, each group with the same blocks.
class PairSum {
 public:
  PairSum(std::vector<int32_t> rows, std::vector<int32_t> columns)
      : rows_(std::move(rows)),
        columns_(std::move(columns)),
        sum_(rows_.size() * columns_.size() * kMatSize),
        row_(columns_.size() * kMatSize) {}

  /// row = sum_q H_pq J_q of one site p, a pair at a time.
  void add_to_row(const Mat3& H, const SiteJacobian& q) {
    for (size_t b = 0; b < q.support_blocks.size(); ++b)
      if (q.support_weights[b] != 0.0) add_weighted(row_block(b), q.support_weights[b], H.m);
    for (int k = 0; k < q.term_count; ++k)
      add_weighted(row_block(q.support_blocks.size() + k), 1.0, (H * q.matrix(q.terms[k])).m);
  }

  /// sum += J_p^T row, and starts the next row.
  void end_row(const SiteJacobian& p) {
    for (size_t a = 0; a < p.support_blocks.size(); ++a)
      if (p.support_weights[a] != 0.0) add_weighted(sum_row(a), p.support_weights[a], row_);
    for (int k = 0; k < p.term_count; ++k) {
      const Mat3 transposed = transpose(p.matrix(p.terms[k]));
      for (size_t b = 0; b < columns_.size(); ++b) {
        Mat3 H;
        std::ranges::copy(row_block(b), H.m.begin());
        add_weighted(sum_row(p.support_blocks.size() + k).subspan(b * kMatSize, kMatSize), 1.0,
                     (transposed * H).m);
      }
    }
    std::ranges::fill(row_, 0.0);
  }

  /// Adds the sum and its transpose, of which the system has the upper triangle.
  void add_to(BlockMatrix& hessian) const {
    for (size_t a = 0; a < rows_.size(); ++a)
      for (size_t b = 0; b < columns_.size(); ++b) {
        if (rows_[a] == kNoBlock || columns_[b] == kNoBlock) continue;
        const double* H = sum_.data() + (a * columns_.size() + b) * kMatSize;
        const int64_t slot =
            hessian.pattern.slot(std::min(rows_[a], columns_[b]), std::max(rows_[a], columns_[b]));
        double* values = hessian.values.data() + kMatSize * slot;
        for (int i = 0; i < 3; ++i)
          for (int j = 0; j < 3; ++j) {
            if (rows_[a] <= columns_[b]) values[3 * i + j] += H[3 * i + j];
            if (rows_[a] >= columns_[b]) values[3 * j + i] += H[3 * i + j];
          }
      }
  }

 private:
  std::span<double> row_block(size_t b) { return std::span(row_).subspan(b * kMatSize, kMatSize); }
  std::span<double> sum_row(size_t a) { return std::span(sum_).subspan(a * row_.size(), row_.size()); }

  std::vector<int32_t> rows_, columns_;
  std::vector<double> sum_;  ///< [row][column][3][3]
  std::vector<double> row_;  ///< [column][3][3]
};

}  // namespace

void SitePairs::add(int32_t p, int32_t q, const Mat3& H) {
  const bool in_order = p <= q;
  const int32_t first = in_order ? p : q, second = in_order ? q : p;
  const uint64_t key = (static_cast<uint64_t>(first) << 32) | static_cast<uint32_t>(second);
  const auto [place, is_new] = places_.try_emplace(key, pairs_.size());
  if (is_new) pairs_.push_back({first, second, Mat3{}});
  Mat3& sum = pairs_[place->second].H;
  for (int i = 0; i < 3; ++i)
    for (int j = 0; j < 3; ++j) sum(i, j) += in_order ? H(i, j) : H(j, i);
}

void SitePairs::scatter(const KinematicMap& map, const Configuration& configuration, BlockMatrix& hessian) {
  struct Placed {
    Group rows, columns;
    const Pair* pair;
  };
  std::vector<Placed> placed;
  placed.reserve(pairs_.size());
  for (const Pair& pair : pairs_) placed.push_back({group_of(map, pair.p), group_of(map, pair.q), &pair});
  std::ranges::sort(placed, {}, [](const Placed& place) {
    return std::tuple(place.rows, place.columns, place.pair->p, place.pair->q);
  });
  const auto jacobian = [&](int32_t site) { return map.jacobian(site, configuration); };
  for (size_t begin = 0, end = 0; begin < placed.size(); begin = end) {
    const Placed& first = placed[begin];
    PairSum sum(moving_blocks(jacobian(first.pair->p)), moving_blocks(jacobian(first.pair->q)));
    const auto is_of_group = [&](size_t k) {
      return k < placed.size() && placed[k].rows == first.rows && placed[k].columns == first.columns;
    };
    for (; is_of_group(end); ++end) {
      const Pair& pair = *placed[end].pair;
      // The sum is added with its transpose: of a pair of a site with itself, twice the half.
      sum.add_to_row(pair.p == pair.q ? pair.H * 0.5 : pair.H, jacobian(pair.q));
      if (!is_of_group(end + 1) || placed[end + 1].pair->p != pair.p) sum.end_row(jacobian(pair.p));
    }
    sum.add_to(hessian);
  }
  pairs_.clear();
  places_.clear();
}

void SupportPairs::add(std::span<const int32_t> stencil) {
  const int32_t first_support = map_.layout().block_count;
  of_stencil_.clear();
  for (const int32_t site : stencil) {
    if (map_.is_embedded(site)) {
      of_stencil_.push_back(first_support + map_.support_index(site));
      continue;
    }
    blocks_.clear();
    map_.append_blocks(site, blocks_);
    of_stencil_.insert(of_stencil_.end(), blocks_.begin(), blocks_.end());
  }
  std::ranges::sort(of_stencil_);
  of_stencil_.erase(std::unique(of_stencil_.begin(), of_stencil_.end()), of_stencil_.end());
  for (size_t a = 0; a < of_stencil_.size(); ++a)
    for (size_t b = a; b < of_stencil_.size(); ++b) groups_.emplace_back(of_stencil_[a], of_stencil_[b]);
}

std::span<const int32_t> SupportPairs::blocks_of(int32_t group, int32_t& storage) const {
  const int32_t first_support = map_.layout().block_count;
  if (group >= first_support) return map_.support_blocks(group - first_support);
  storage = group;
  return {&storage, 1};
}

void SupportPairs::append_to(std::vector<std::pair<int32_t, int32_t>>& out) {
  std::ranges::sort(groups_);
  groups_.erase(std::unique(groups_.begin(), groups_.end()), groups_.end());
  int32_t of_first = 0, of_second = 0;
  for (const auto& [first, second] : groups_)
    for (const int32_t a : blocks_of(first, of_first))
      for (const int32_t b : blocks_of(second, of_second))
        if (a != kNoBlock && b != kNoBlock && a != b) out.emplace_back(std::min(a, b), std::max(a, b));
  groups_.clear();
}

}  // namespace stark
