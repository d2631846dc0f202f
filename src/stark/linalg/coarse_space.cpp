#include <stark/linalg/coarse_space.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <numeric>

#include <stark/base/error.h>

namespace stark {

namespace {

constexpr int32_t kLeastCluster = 64;  // blocks
// k clusters for n blocks with k^3 = 10 n: the dense factor, 72 k^3 flops, costs as much as a few products
// with A. Measured: 3 to 10 are best, 30 is slower.
constexpr int64_t kCubeOfClustersPerBlock = 10;
// Rigid modes of clusters on a line or a point are zero; this part of the largest diagonal entry keeps the
// factor regular.
constexpr double kRegularization = 1e-9;
constexpr int64_t kClusterGrain = 1;

// The columns of A that a mode (t, theta) of a node at the arm d moves: A t + A (theta x d).
void add_columns(const double* a, const Vec3& d, double scale, double* out) {
  for (int r = 0; r < 3; ++r) {
    const double x = scale * a[3 * r], y = scale * a[3 * r + 1], z = scale * a[3 * r + 2];
    double* o = out + 6 * r;
    o[0] += x;
    o[1] += y;
    o[2] += z;
    o[3] += d[1] * z - d[2] * y;
    o[4] += d[2] * x - d[0] * z;
    o[5] += d[0] * y - d[1] * x;
  }
}

// Rows of P^T: forces y of a node at the arm d as force and moment, y and d x y.
void add_rows(const double* y, const Vec3& d, double* out) {
  for (int c = 0; c < 6; ++c) {
    const double y0 = y[c], y1 = y[6 + c], y2 = y[12 + c];
    out[c] += y0;
    out[6 + c] += y1;
    out[12 + c] += y2;
    out[18 + c] += d[1] * y2 - d[2] * y1;
    out[24 + c] += d[2] * y0 - d[0] * y2;
    out[30 + c] += d[0] * y1 - d[1] * y0;
  }
}

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
  return static_cast<int32_t>(k);
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
  rows_.resize(clustered_count_);
  for (int32_t i = 0; i < n; ++i) {
    const int32_t root = find_root(parent, i);
    if (size[root] >= 2 * kLeastCluster) rows_[next[root]++] = i;
  }
  cluster_.assign(n, -1);
  arm_.assign(n, Vec3{});
}

void CoarseSpace::set_positions(std::span<const Vec3> positions) {
  STARK_CHECK(positions.size() == cluster_.size());
  const int32_t largest = std::max(kLeastCluster, clustered_count_ / wanted_clusters(clustered_count_));
  row_begin_.assign(1, 0);
  std::vector<Range> open(parts_.rbegin(), parts_.rend());
  while (!open.empty()) {
    const Range range = open.back();
    open.pop_back();
    const std::span<int32_t> rows(rows_.data() + range.begin, rows_.data() + range.end);
    if (range.end - range.begin <= largest) {
      row_begin_.push_back(range.end);
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
  for (int32_t cluster = 0; cluster < cluster_count(); ++cluster) {
    const auto [begin, end] = rows_of(cluster);
    std::sort(rows_.begin() + begin, rows_.begin() + end);
    Vec3 middle{};
    for (int32_t k = begin; k < end; ++k) middle = middle + positions[rows_[k]];
    middle = middle * (1.0 / (end - begin));
    double radius = 0.0;
    for (int32_t k = begin; k < end; ++k) radius = std::max(radius, norm(positions[rows_[k]] - middle));
    for (int32_t k = begin; k < end; ++k) {
      cluster_[rows_[k]] = cluster;
      arm_[rows_[k]] = radius > 0.0 ? (positions[rows_[k]] - middle) * (1.0 / radius) : Vec3{};
    }
  }
  if (coarse_.pattern.block_count != 2 * cluster_count()) make_dense_pattern();
}

void CoarseSpace::make_dense_pattern() {
  const int32_t n = 2 * cluster_count();
  BlockPattern& pattern = coarse_.pattern;
  pattern.block_count = n;
  pattern.row_start.assign(1, 0);
  pattern.column.clear();
  for (int32_t i = 0; i < n; ++i) {
    for (int32_t j = i; j < n; ++j) pattern.column.push_back(j);
    pattern.row_start.push_back(static_cast<int64_t>(pattern.column.size()));
  }
  cholesky_.analyze(pattern);
}

void CoarseSpace::project_cluster(const BlockMatrix& matrix, int32_t cluster) {
  struct Columns {  // of one row of A, summed over a cluster
    int32_t cluster;
    std::array<double, 18> values;
  };
  std::vector<Columns> found;
  double* out = projected_.data() + 36 * static_cast<int64_t>(cluster) * cluster_count();
  std::fill(out, out + 36 * static_cast<int64_t>(cluster_count()), 0.0);
  const auto [begin, end] = rows_of(cluster);
  for (int32_t k = begin; k < end; ++k) {
    const int32_t i = rows_[k];
    found.clear();
    for (int64_t slot = matrix.pattern.row_start[i]; slot < matrix.pattern.row_start[i + 1]; ++slot) {
      const int32_t j = matrix.pattern.column[slot], other = cluster_[j];
      if (other < 0) continue;
      auto at =
          std::find_if(found.begin(), found.end(), [&](const Columns& c) { return c.cluster == other; });
      if (at == found.end()) at = found.insert(found.end(), {other, {}});
      add_columns(matrix.values.data() + 9 * slot, arm_[j], j == i ? 0.5 : 1.0, at->values.data());
    }
    for (const Columns& columns : found)
      add_rows(columns.values.data(), arm_[i], out + 36 * static_cast<int64_t>(columns.cluster));
  }
}

bool CoarseSpace::factor(const BlockMatrix& matrix, ThreadPool& pool) {
  const int64_t count = cluster_count();
  projected_.resize(36 * count * count);
  pool.for_each_range(count, kClusterGrain, [&](int64_t begin, int64_t end) {
    for (int64_t cluster = begin; cluster < end; ++cluster)
      project_cluster(matrix, static_cast<int32_t>(cluster));
  });
  coarse_.set_zero();
  // P^T A P is what was projected plus its transpose.
  for (int64_t i = 0; i < 2 * count; ++i) {
    double* row = coarse_.values.data() + 9 * coarse_.pattern.row_start[i];
    for (int64_t j = i; j < 2 * count; ++j, row += 9) {
      const double* upper = projected_.data() + 36 * ((i / 2) * count + j / 2) + 18 * (i % 2) + 3 * (j % 2);
      const double* lower = projected_.data() + 36 * ((j / 2) * count + i / 2) + 18 * (j % 2) + 3 * (i % 2);
      for (int r = 0; r < 3; ++r)
        for (int c = 0; c < 3; ++c) row[3 * r + c] = upper[6 * r + c] + lower[6 * c + r];
    }
  }
  for (int64_t i = 0; i < count; ++i) {
    double* blocks[2] = {coarse_.values.data() + 9 * coarse_.pattern.row_start[2 * i],
                         coarse_.values.data() + 9 * coarse_.pattern.row_start[2 * i + 1]};
    double largest = 0.0;
    for (double* block : blocks)
      for (int a = 0; a < 3; ++a) largest = std::max(largest, std::fabs(block[4 * a]));
    for (double* block : blocks)
      for (int a = 0; a < 3; ++a) block[4 * a] += kRegularization * largest;
  }
  return cholesky_.factor(coarse_, pool).positive_definite;
}

double CoarseSpace::correct(const double* r, double* z, ThreadPool& pool) {
  const int64_t count = cluster_count();
  right_.resize(6 * count);
  solution_.resize(6 * count);
  pool.for_each_range(count, kClusterGrain, [&](int64_t first, int64_t last) {
    for (int64_t cluster = first; cluster < last; ++cluster) {
      Vec3 force{}, moment{};
      const auto [begin, end] = rows_of(static_cast<int32_t>(cluster));
      for (int32_t k = begin; k < end; ++k) {
        const double* y = r + 3 * static_cast<int64_t>(rows_[k]);
        const Vec3 f{y[0], y[1], y[2]};
        force = force + f;
        moment = moment + cross(arm_[rows_[k]], f);
      }
      for (int a = 0; a < 3; ++a) {
        right_[6 * cluster + a] = force[a];
        right_[6 * cluster + 3 + a] = moment[a];
      }
    }
  });
  cholesky_.solve(right_.data(), solution_.data());
  pool.for_each_range(count, kClusterGrain, [&](int64_t first, int64_t last) {
    for (int64_t cluster = first; cluster < last; ++cluster) {
      const double* c = solution_.data() + 6 * cluster;
      const Vec3 shift{c[0], c[1], c[2]}, turn{c[3], c[4], c[5]};
      const auto [begin, end] = rows_of(static_cast<int32_t>(cluster));
      for (int32_t k = begin; k < end; ++k) {
        const Vec3 u = shift + cross(turn, arm_[rows_[k]]);
        for (int a = 0; a < 3; ++a) z[3 * static_cast<int64_t>(rows_[k]) + a] += u[a];
      }
    }
  });
  return std::inner_product(right_.begin(), right_.end(), solution_.begin(), 0.0);
}

}  // namespace stark
