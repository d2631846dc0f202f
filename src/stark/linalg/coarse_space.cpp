#include <stark/linalg/coarse_space.h>

#include <algorithm>
#include <cmath>
#include <numeric>

#include <stark/base/error.h>

namespace stark {

namespace {

constexpr int32_t kLeastCluster = 64;  // blocks
// k clusters for n blocks with k^3 = 10 n: the factor, up to 72 k^3 flops, costs as much as a few products
// with A. Measured: 3 to 10 are best, 30 is slower. The factor of many clusters is sparse, and cheaper.
constexpr int64_t kCubeOfClustersPerBlock = 10;
constexpr int64_t kBlocksOfCluster = 300;
// Rigid modes of clusters on a line or a point are zero; this part of the largest diagonal entry keeps the
// factor regular.
constexpr double kRegularization = 1e-9;
constexpr int64_t kClusterGrain = 4;

int longest_direction(std::span<const int32_t> rows, std::span<const Vec3> positions) {
  Vec3 low = positions[rows.front()], high = low;
  for (int32_t row : rows) {
    for (int a = 0; a < 3; ++a) {
      low[a] = std::min(low[a], positions[row][a]);
      high[a] = std::max(high[a], positions[row][a]);
    }
  }
  const Vec3 extent = high - low;
  return extent[0] >= extent[1] && extent[0] >= extent[2] ? 0 : (extent[1] >= extent[2] ? 1 : 2);
}

// In integers: the last bit of a cube root differs between processors.
int32_t wanted_clusters(int64_t block_count) {
  int64_t k = 1;
  while ((k + 1) * (k + 1) * (k + 1) <= kCubeOfClustersPerBlock * block_count) ++k;
  return static_cast<int32_t>(std::max(k, block_count / kBlocksOfCluster));
}

int32_t find_root(std::vector<int32_t>& parent, int32_t i) {
  while (parent[i] != i) i = parent[i] = parent[parent[i]];
  return i;
}

}  // namespace

void CoarseSpace::prepare(const BlockPattern& pattern) {
  const int32_t n = pattern.block_count;
  std::vector<int32_t> parent(n), size(n, 0), next(n, 0);
  std::iota(parent.begin(), parent.end(), 0);
  for (int32_t i = 0; i < n; ++i) {
    for (int64_t k = pattern.row_start[i] + 1; k < pattern.row_start[i + 1]; ++k) {
      const int32_t a = find_root(parent, i), b = find_root(parent, pattern.column[k]);
      parent[std::max(a, b)] = std::min(a, b);
    }
  }
  for (int32_t i = 0; i < n; ++i) ++size[find_root(parent, i)];
  parts_.clear();
  clustered_count_ = 0;
  for (int32_t i = 0; i < n; ++i) {
    if (parent[i] != i || size[i] < 2 * kLeastCluster) continue;
    next[i] = clustered_count_;
    parts_.push_back({clustered_count_, clustered_count_ + size[i]});
    clustered_count_ += size[i];
  }
  order_.resize(n);
  int32_t tail = clustered_count_;
  for (int32_t i = 0; i < n; ++i) {
    const int32_t root = find_root(parent, i);
    order_[size[root] >= 2 * kLeastCluster ? next[root]++ : tail++] = i;
  }
  cluster_.assign(n, -1);
  arm_.assign(n, Vec3{});
  ordered_arm_.assign(clustered_count_, Vec3{});
}

void CoarseSpace::bisect_parts(std::span<const Vec3> positions) {
  const int32_t largest = std::max(kLeastCluster, clustered_count_ / wanted_clusters(clustered_count_));
  cluster_ends_.clear();
  std::vector<Range> open(parts_.rbegin(), parts_.rend());
  while (!open.empty()) {
    const Range range = open.back();
    open.pop_back();
    const std::span<int32_t> rows(order_.data() + range.begin, order_.data() + range.end);
    if (range.end - range.begin <= largest) {
      cluster_ends_.push_back(range.end);
      continue;
    }
    const int axis = longest_direction(rows, positions);
    const size_t half = rows.size() / 2;
    std::nth_element(rows.begin(), rows.begin() + half, rows.end(), [&](int32_t i, int32_t j) {
      return positions[i][axis] != positions[j][axis] ? positions[i][axis] < positions[j][axis] : i < j;
    });
    const int32_t middle = range.begin + static_cast<int32_t>(half);
    open.push_back({middle, range.end});
    open.push_back({range.begin, middle});
  }
}

void CoarseSpace::set_positions(std::span<const Vec3> positions) {
  STARK_CHECK(positions.size() == cluster_.size());
  bisect_parts(positions);
  for (int32_t cluster = 0; cluster < cluster_count(); ++cluster) {
    const auto [begin, end] = range_of(cluster);
    std::sort(order_.begin() + begin, order_.begin() + end);
    Vec3 middle{};
    for (int32_t k = begin; k < end; ++k) middle = middle + positions[order_[k]];
    middle = middle * (1.0 / (end - begin));
    double radius = 0.0;
    for (int32_t k = begin; k < end; ++k) radius = std::max(radius, norm(positions[order_[k]] - middle));
    for (int32_t k = begin; k < end; ++k) {
      const int32_t i = order_[k];
      cluster_[i] = cluster;
      arm_[i] = radius > 0.0 ? (positions[i] - middle) * (1.0 / radius) : Vec3{};
      ordered_arm_[k] = arm_[i];
    }
  }
}

// That of the projected blocks. Ordered anew whenever it changes, so that the factor depends on it alone.
void CoarseSpace::make_pattern() {
  std::vector<std::pair<int32_t, int32_t>> pairs;
  for (int32_t c = 0; c < cluster_count(); ++c)
    for (const CoarseBlock& block : projected_[c])
      for (const auto& [i, j] : {std::pair{0, 0}, {0, 1}, {1, 0}, {1, 1}})
        pairs.emplace_back(2 * c + i, 2 * block.cluster + j);
  BlockPattern pattern = BlockPattern::from_pairs(2 * cluster_count(), std::move(pairs));
  if (pattern == coarse_.pattern) return;
  coarse_.pattern = std::move(pattern);
  cholesky_.begin_sequence();
  cholesky_.analyze(coarse_.pattern);
}

// P^T A P: what was projected, plus its transpose.
void CoarseSpace::fill_matrix() {
  coarse_.set_zero();
  for (int32_t c = 0; c < cluster_count(); ++c)
    for (const CoarseBlock& block : projected_[c])
      for (int i = 0; i < 2; ++i)
        for (int j = 0; j < 2; ++j) {
          const int32_t row = 2 * c + i, column = 2 * block.cluster + j;
          double* low =
              coarse_.values.data() + 9 * coarse_.pattern.slot(std::min(row, column), std::max(row, column));
          for (int r = 0; r < 3; ++r)
            for (int s = 0; s < 3; ++s) {
              const double value = block(3 * i + r, 3 * j + s);
              if (row <= column) low[3 * r + s] += value;
              if (row >= column) low[3 * s + r] += value;
            }
        }
}

bool CoarseSpace::factor(const BlockMatrix& matrix, ThreadPool& pool) {
  const int64_t count = cluster_count();
  projected_.resize(count);
  pool.for_each_range(count, kClusterGrain, [&](int64_t first, int64_t last) {
    for (int64_t cluster = first; cluster < last; ++cluster) {
      const auto [begin, end] = range_of(static_cast<int32_t>(cluster));
      project_cluster(matrix, order().subspan(begin, end - begin), {cluster_, arm_}, projected_[cluster]);
    }
  });
  make_pattern();
  fill_matrix();
  for (int64_t i = 0; i < count; ++i) {
    double* blocks[2] = {coarse_.values.data() + 9 * coarse_.pattern.row_start[2 * i],
                         coarse_.values.data() + 9 * coarse_.pattern.row_start[2 * i + 1]};
    double largest = 0.0;
    for (double* block : blocks)
      for (int a = 0; a < 3; ++a) largest = std::max(largest, std::fabs(block[4 * a]));
    for (double* block : blocks)
      for (int a = 0; a < 3; ++a) block[4 * a] += kRegularization * largest;
  }
  right_.resize(6 * count);
  solution_.resize(6 * count);
  return cholesky_.factor(coarse_, pool).positive_definite;
}

void CoarseSpace::take_forces(int32_t cluster, const double* r) {
  Vec3 force{}, moment{};
  const auto [begin, end] = range_of(cluster);
  for (int64_t k = begin; k < end; ++k) {
    const Vec3 f{r[3 * k], r[3 * k + 1], r[3 * k + 2]};
    force = force + f;
    moment = moment + cross(ordered_arm_[k], f);
  }
  double* right = right_.data() + 6 * static_cast<int64_t>(cluster);
  for (int a = 0; a < 3; ++a) {
    right[a] = force[a];
    right[3 + a] = moment[a];
  }
}

double CoarseSpace::solve(ThreadPool& pool) {
  cholesky_.solve(right_.data(), solution_.data(), pool);
  return std::inner_product(right_.begin(), right_.end(), solution_.begin(), 0.0);
}

void CoarseSpace::add_motion(int32_t cluster, double* z) const {
  const double* c = solution_.data() + 6 * static_cast<int64_t>(cluster);
  const Vec3 shift{c[0], c[1], c[2]}, turn{c[3], c[4], c[5]};
  const auto [begin, end] = range_of(cluster);
  for (int64_t k = begin; k < end; ++k) {
    const Vec3 u = shift + cross(turn, ordered_arm_[k]);
    for (int a = 0; a < 3; ++a) z[3 * k + a] += u[a];
  }
}

}  // namespace stark
