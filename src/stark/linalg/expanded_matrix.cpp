#include <stark/linalg/expanded_matrix.h>

#include <algorithm>

#include <stark/linalg/block_rows.h>

namespace stark {

namespace {

constexpr int64_t kRowGrain = 512;  // block rows of one task

}  // namespace

void ExpandedMatrix::expand_structure(const BlockPattern& pattern) {
  const int32_t n = block_count_ = pattern.block_count;
  std::vector<int64_t> below(n, 0);
  for (int32_t i = 0; i < n; ++i)
    for (int64_t slot = pattern.row_start[i] + 1; slot < pattern.row_start[i + 1]; ++slot)
      ++below[pattern.column[slot]];
  row_start_.assign(static_cast<size_t>(n) + 1, 0);
  above_.resize(n);
  for (int32_t i = 0; i < n; ++i) {
    above_[i] = row_start_[i] + below[i];
    row_start_[i + 1] = above_[i] + pattern.row_start[i + 1] - pattern.row_start[i] - 1;
  }
  column_.resize(row_start_[n]);
  source_.resize(row_start_[n]);
  // Rows are visited in order, so that every row receives its lower columns sorted.
  below.assign(row_start_.begin(), row_start_.end() - 1);
  for (int32_t i = 0; i < n; ++i) {
    const int64_t first = pattern.row_start[i] + 1, last = pattern.row_start[i + 1] - 1;
    for (int64_t slot = first; slot <= last; ++slot) {
      const int32_t j = pattern.column[slot];
      const int64_t right = above_[i] + (order_ == Above::Ascending ? slot - first : last - slot);
      column_[right] = j;
      source_[right] = 2 * slot;
      column_[below[j]] = i;
      source_[below[j]++] = 2 * slot + 1;
    }
  }
}

bool ExpandedMatrix::prepare(const BlockMatrix& matrix, PcgStorage storage, ThreadPool& pool) {
  const BlockPattern& pattern = matrix.pattern;
  const uint64_t hash = pattern.hash();
  if (row_start_.empty() || hash != pattern_hash_ || pattern.block_count != block_count_) {
    expand_structure(pattern);
    pattern_hash_ = hash;
  }
  storage_ = storage;
  diagonal_.resize(9 * static_cast<size_t>(block_count_) + 1);  // last columns are read as four entries
  inverse_.resize(diagonal_.size());
  if (storage == PcgStorage::Double)
    blocks_.resize(9 * column_.size() + 1);
  else
    blocks_float_.resize(9 * column_.size() + 1);
  std::vector<int32_t> failed((block_count_ + kRowGrain - 1) / kRowGrain, -1);
  pool.for_each_range(block_count_, kRowGrain, [&](int64_t begin, int64_t end) {
    copy_rows(matrix, begin, end);
    for (int64_t i = begin; i < end; ++i)
      if (!invert_spd(diagonal_.data() + 9 * i, inverse_.data() + 9 * i) && failed[begin / kRowGrain] < 0)
        failed[begin / kRowGrain] = static_cast<int32_t>(i);
  });
  const auto first = std::ranges::find_if(failed, [](int32_t block) { return block >= 0; });
  failed_block_ = first == failed.end() ? -1 : *first;
  return failed_block_ < 0;
}

void ExpandedMatrix::copy_rows(const BlockMatrix& matrix, int64_t begin, int64_t end) {
  for (int64_t i = begin; i < end; ++i) {
    const double* d = matrix.values.data() + 9 * matrix.pattern.row_start[i];
    std::copy(d, d + 9, diagonal_.data() + 9 * i);
  }
  const auto copy = [&](auto* blocks) {
    for (int64_t k = row_start_[begin]; k < row_start_[end]; ++k)
      copy_columns(matrix.values.data() + 9 * (source_[k] >> 1), (source_[k] & 1) != 0, blocks + 9 * k);
  };
  if (storage_ == PcgStorage::Double)
    copy(blocks_.data());
  else
    copy(blocks_float_.data());
}

}  // namespace stark
