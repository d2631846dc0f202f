// Block patterns by bucket sort, and the symmetric product from the upper triangle.
#include <stark/linalg/block_matrix.h>

#include <algorithm>
#include <cstring>
#include <memory>

#include <stark/base/error.h>

namespace stark {

namespace {

constexpr int64_t kValuesPerTask = 65536;

// Columns of `pairs` (ordered as upper) bucketed by row: rows are unsorted and may hold duplicates.
struct Buckets {
  std::vector<int64_t> start;
  std::vector<int32_t> column;
};

Buckets bucket_by_row(int32_t block_count, std::span<const std::pair<int32_t, int32_t>> pairs) {
  Buckets buckets;
  buckets.start.assign(static_cast<size_t>(block_count) + 1, 0);
  for (const auto& [a, b] : pairs) {
    STARK_CHECK(std::min(a, b) >= 0 && std::max(a, b) < block_count);
    ++buckets.start[std::min(a, b) + 1];
  }
  for (int32_t i = 0; i < block_count; ++i) buckets.start[i + 1] += buckets.start[i];
  buckets.column.resize(pairs.size());
  std::vector<int64_t> next(buckets.start.begin(), buckets.start.end() - 1);
  for (const auto& [a, b] : pairs) buckets.column[next[std::min(a, b)]++] = std::max(a, b);
  return buckets;
}

// Appends the distinct columns of bucket `i` that are not yet marked with `i` to `out`, sorted.
void append_distinct(const Buckets& buckets, int32_t i, std::vector<int32_t>& mark,
                     std::vector<int32_t>& out) {
  const size_t begin = out.size();
  for (int64_t k = buckets.start[i]; k < buckets.start[i + 1]; ++k) {
    const int32_t j = buckets.column[k];
    if (mark[j] == i) continue;
    mark[j] = i;
    out.push_back(j);
  }
  std::sort(out.begin() + static_cast<ptrdiff_t>(begin), out.end());
}

uint64_t mix(uint64_t h, uint64_t value) {
  const unsigned __int128 product = static_cast<unsigned __int128>(h ^ value) * 0x9e3779b97f4a7c15ull;
  return static_cast<uint64_t>(product) ^ static_cast<uint64_t>(product >> 64) ^ 0x2545f4914f6cdd1dull;
}

}  // namespace

BlockPattern BlockPattern::from_pairs(int32_t block_count, std::vector<std::pair<int32_t, int32_t>> pairs) {
  const Buckets buckets = bucket_by_row(block_count, pairs);
  BlockPattern pattern;
  pattern.block_count = block_count;
  pattern.row_start.reserve(static_cast<size_t>(block_count) + 1);
  pattern.row_start.push_back(0);
  pattern.column.reserve(static_cast<size_t>(block_count) + pairs.size() / 2);
  std::vector<int32_t> mark(block_count, -1);
  for (int32_t i = 0; i < block_count; ++i) {
    mark[i] = i;
    pattern.column.push_back(i);
    append_distinct(buckets, i, mark, pattern.column);
    pattern.row_start.push_back(pattern.slot_count());
  }
  return pattern;
}

BlockPattern BlockPattern::merged_with(std::span<const std::pair<int32_t, int32_t>> pairs,
                                       std::vector<int64_t>& out_slot_of_base) const {
  const Buckets buckets = bucket_by_row(block_count, pairs);
  BlockPattern pattern;
  pattern.block_count = block_count;
  pattern.row_start.resize(static_cast<size_t>(block_count) + 1);
  pattern.row_start[0] = 0;
  pattern.column.reserve(column.size() + pairs.size());
  out_slot_of_base.resize(column.size());
  std::vector<int32_t> mark(block_count, -1), added;
  for (int32_t i = 0; i < block_count; ++i) {
    const int64_t begin = row_start[i], end = row_start[i + 1];
    added.clear();
    if (buckets.start[i] < buckets.start[i + 1]) {
      for (int64_t k = begin; k < end; ++k) mark[column[k]] = i;
      append_distinct(buckets, i, mark, added);
    }
    size_t next = 0;
    for (int64_t k = begin; k < end; ++k) {
      while (next < added.size() && added[next] < column[k]) pattern.column.push_back(added[next++]);
      out_slot_of_base[k] = pattern.slot_count();
      pattern.column.push_back(column[k]);
    }
    while (next < added.size()) pattern.column.push_back(added[next++]);
    pattern.row_start[i + 1] = pattern.slot_count();
  }
  return pattern;
}

int64_t BlockPattern::slot(int32_t i, int32_t j) const {
  STARK_CHECK(0 <= i && i <= j && j < block_count);
  const auto begin = column.begin() + row_start[i], end = column.begin() + row_start[i + 1];
  const auto found = std::lower_bound(begin, end, j);
  return found != end && *found == j ? found - column.begin() : -1;
}

uint64_t BlockPattern::hash() const {
  uint64_t h = mix(0x51ed270b7f4a7c15ull, static_cast<uint64_t>(block_count));
  h = mix(h, static_cast<uint64_t>(column.size()));
  // Row starts and columns are both needed: equal column lists can be cut into rows in two ways. A row begins
  // with its own index, so mixing the row starts through four lanes costs little.
  uint64_t lane[4] = {h, h + 1, h + 2, h + 3};
  const size_t rows = row_start.size();
  for (size_t i = 0; i < rows; ++i) lane[i & 3] = mix(lane[i & 3], static_cast<uint64_t>(row_start[i]));
  const size_t pairs = column.size() / 2;
  for (size_t k = 0; k < pairs; ++k) {
    uint64_t two;
    std::memcpy(&two, column.data() + 2 * k, sizeof(two));
    lane[k & 3] = mix(lane[k & 3], two);
  }
  if (column.size() % 2 != 0) lane[0] = mix(lane[0], static_cast<uint64_t>(column.back()));
  return mix(mix(lane[0], lane[1]), mix(lane[2], lane[3]));
}

void BlockMatrix::set_zero() {
  ThreadPool alone(1);
  set_zero(alone);
}

void BlockMatrix::set_zero(ThreadPool& pool) {
  values.resize(static_cast<size_t>(pattern.slot_count()) * 9);
  pool.for_each_range(std::ssize(values), kValuesPerTask, [&](int64_t begin, int64_t end) {
    std::fill(values.begin() + begin, values.begin() + end, 0.0);
  });
}

void BlockMatrix::multiply(const double* x, double* y, ThreadPool& pool) const {
  const int32_t n = pattern.block_count;
  // Chunks of rows add into private copies of y, summed in chunk order: their number depends on the size
  // only.
  const int32_t chunks = n < 4096 ? 1 : 8;
  const auto multiply_rows = [&](int32_t begin, int32_t end, double* out) {
    for (int32_t i = begin; i < end; ++i) {
      const double x0 = x[3 * i], x1 = x[3 * i + 1], x2 = x[3 * i + 2];
      int64_t k = pattern.row_start[i];
      const double* d = values.data() + 9 * k;
      double y0 = d[0] * x0 + d[1] * x1 + d[2] * x2;
      double y1 = d[3] * x0 + d[4] * x1 + d[5] * x2;
      double y2 = d[6] * x0 + d[7] * x1 + d[8] * x2;
      for (++k; k < pattern.row_start[i + 1]; ++k) {
        const double* a = values.data() + 9 * k;
        const int64_t j = 3 * static_cast<int64_t>(pattern.column[k]);
        const double u0 = x[j], u1 = x[j + 1], u2 = x[j + 2];
        y0 += a[0] * u0 + a[1] * u1 + a[2] * u2;
        y1 += a[3] * u0 + a[4] * u1 + a[5] * u2;
        y2 += a[6] * u0 + a[7] * u1 + a[8] * u2;
        out[j] += a[0] * x0 + a[3] * x1 + a[6] * x2;
        out[j + 1] += a[1] * x0 + a[4] * x1 + a[7] * x2;
        out[j + 2] += a[2] * x0 + a[5] * x1 + a[8] * x2;
      }
      out[3 * i] += y0;
      out[3 * i + 1] += y1;
      out[3 * i + 2] += y2;
    }
  };
  const int64_t size = 3 * static_cast<int64_t>(n);
  if (chunks == 1) {
    std::fill(y, y + size, 0.0);
    multiply_rows(0, n, y);
    return;
  }
  const auto partial = std::make_unique_for_overwrite<double[]>((chunks - 1) * size);
  pool.for_each_task(chunks, [&](int64_t chunk, int) {
    const auto begin = static_cast<int32_t>(chunk * n / chunks),
               end = static_cast<int32_t>((chunk + 1) * n / chunks);
    double* const out = chunk == 0 ? y : partial.get() + (chunk - 1) * size;
    std::fill(out, out + size, 0.0);
    multiply_rows(begin, end, out);
  });
  pool.for_each_range(size, 4096, [&](int64_t begin, int64_t end) {
    for (int32_t chunk = 0; chunk < chunks - 1; ++chunk) {
      const double* part = partial.get() + chunk * size;
      for (int64_t k = begin; k < end; ++k) y[k] += part[k];
    }
  });
}

}  // namespace stark
