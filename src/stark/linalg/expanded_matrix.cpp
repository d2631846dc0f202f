#include <stark/linalg/expanded_matrix.h>

#include <algorithm>
#include <type_traits>

#include <stark/base/error.h>
#include <stark/linalg/block_rows.h>

namespace stark {

namespace {

constexpr int64_t kRowGrain = 512;  // block rows of one task
constexpr int32_t kNone = INT32_MAX;

}  // namespace

void ExpandedMatrix::expand_structure(const BlockPattern& pattern, std::span<const int32_t> order) {
  const int32_t n = block_count_ = pattern.block_count;
  STARK_CHECK(pattern.column.size() <= UINT32_MAX / 2);  // 150 GB of blocks
  source_row_.assign(order.begin(), order.end());
  std::vector<int32_t> place(n);
  for (int32_t k = 0; k < n; ++k) place[source_row(k)] = k;
  std::vector<int64_t> below(n, 0);
  for (int32_t i = 0; i < n; ++i)
    for (int64_t slot = pattern.row_start[i] + 1; slot < pattern.row_start[i + 1]; ++slot)
      ++below[place[pattern.column[slot]]];
  row_start_.assign(static_cast<size_t>(n) + 1, 0);
  above_.resize(n);
  for (int32_t k = 0; k < n; ++k) {
    const int32_t i = source_row(k);
    above_[k] = row_start_[k] + below[k];
    row_start_[k + 1] = above_[k] + pattern.row_start[i + 1] - pattern.row_start[i] - 1;
  }
  column_.resize(row_start_[n]);
  source_.resize(row_start_[n]);
  // Rows are visited in order, so that every row receives its lower columns sorted.
  below.assign(row_start_.begin(), row_start_.end() - 1);
  for (int32_t i = 0; i < n; ++i) {
    const int64_t first = pattern.row_start[i] + 1, last = pattern.row_start[i + 1] - 1;
    for (int64_t slot = first; slot <= last; ++slot) {
      const int32_t j = place[pattern.column[slot]];
      const int64_t right = above_[place[i]] + (order_ == Above::Ascending ? slot - first : last - slot);
      column_[right] = j;
      source_[right] = static_cast<uint32_t>(2 * slot);
      column_[below[j]] = place[i];
      source_[below[j]++] = static_cast<uint32_t>(2 * slot + 1);
    }
  }
}

bool ExpandedMatrix::prepare(const BlockMatrix& matrix, PcgStorage storage, ThreadPool& pool,
                             std::span<const int32_t> order) {
  const BlockPattern& pattern = matrix.pattern;
  STARK_CHECK(order.empty() || order.size() == static_cast<size_t>(pattern.block_count));
  const uint64_t hash = pattern.hash();
  if (row_start_.empty() || hash != pattern_hash_ || pattern.block_count != block_count_ ||
      !std::ranges::equal(order, source_row_)) {
    expand_structure(pattern, order);
    pattern_hash_ = hash;
  }
  storage_ = storage;
  diagonal_.resize(9 * static_cast<size_t>(block_count_) + 1);  // last columns are read as four entries
  inverse_.resize(diagonal_.size());
  if (storage == PcgStorage::Double)
    blocks_.resize(9 * column_.size() + 1);
  else
    blocks_float_.resize(9 * column_.size() + 1);
  std::vector<int32_t> failed((block_count_ + kRowGrain - 1) / kRowGrain, kNone);
  pool.for_each_range(block_count_, kRowGrain, [&](int64_t begin, int64_t end) {
    failed[begin / kRowGrain] = copy_rows(matrix, begin, end);
  });
  const int32_t first = failed.empty() ? kNone : *std::ranges::min_element(failed);
  failed_block_ = first == kNone ? -1 : first;
  return failed_block_ < 0;
}

// And inverts diagonal blocks. Returns the first row of the matrix whose block is not positive definite.
int32_t ExpandedMatrix::copy_rows(const BlockMatrix& matrix, int64_t begin, int64_t end) {
  int32_t failed = kNone;
  for (int64_t k = begin; k < end; ++k) {
    const double* d = matrix.values.data() + 9 * matrix.pattern.row_start[source_row(k)];
    std::copy(d, d + 9, diagonal_.data() + 9 * k);
    if (!invert_spd(d, inverse_.data() + 9 * k)) failed = std::min(failed, source_row(k));
  }
  if (storage_ == PcgStorage::Double)
    copy_blocks(matrix, begin, end, blocks_.data());
  else
    copy_blocks(matrix, begin, end, blocks_float_.data());
  return failed;
}

template <typename Real>
void ExpandedMatrix::copy_blocks(const BlockMatrix& matrix, int64_t begin, int64_t end, Real* blocks) {
  const bool sums = std::is_same_v<Real, float> && of_float_ == Diagonal::RowSum;
  for (int64_t i = begin; i < end; ++i) {
    double* sum = diagonal_.data() + 9 * i;
    for (int64_t k = row_start_[i]; k < row_start_[i + 1]; ++k) {
      const double* a = matrix.values.data() + 9 * static_cast<int64_t>(source_[k] >> 1);
      const bool is_transposed = (source_[k] & 1) != 0;
      copy_columns(a, is_transposed, blocks + 9 * k);
      if (sums) add_block(a, is_transposed, sum);
    }
  }
}

}  // namespace stark
