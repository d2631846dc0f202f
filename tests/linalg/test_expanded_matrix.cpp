// The expanded matrix: both triangles of every row, in the order that is asked for.
#include <stark/linalg/expanded_matrix.h>

#include <vector>

#include <doctest/doctest.h>

#include "linalg/systems.h"

using namespace stark;

TEST_CASE("rows have what is below the diagonal in order, then what is above it in the order asked for") {
  // Row 1 of a star around it, with a chain: below 0, above 2, 3, 4.
  const BlockMatrix matrix =
      test::spd_matrix(BlockPattern::from_pairs(5, {{0, 1}, {1, 2}, {1, 3}, {1, 4}, {3, 4}}), 5);
  ThreadPool pool(2);
  using Above = ExpandedMatrix::Above;
  for (const auto& [order, columns] :
       {std::pair{Above::Ascending, std::vector<int32_t>{0, 2, 3, 4}}, {Above::Descending, {0, 4, 3, 2}}}) {
    ExpandedMatrix rows(order);
    REQUIRE(rows.prepare(matrix, PcgStorage::Double, pool));
    CHECK(rows.above(1) == rows.row_begin(1) + 1);
    CHECK(std::vector<int32_t>(rows.column() + rows.row_begin(1), rows.column() + rows.row_end(1)) ==
          columns);
    // Column by column: block (1, j) of the upper triangle, the transposed one of the lower triangle.
    rows.with_blocks([&](const auto* blocks) {
      for (int64_t k = rows.row_begin(1); k < rows.row_end(1); ++k) {
        const int32_t j = rows.column()[k], low = std::min(1, j), high = std::max(1, j);
        const double* a = matrix.values.data() + 9 * matrix.pattern.slot(low, high);
        for (int r = 0; r < 3; ++r)
          for (int c = 0; c < 3; ++c)
            CHECK(blocks[9 * k + 3 * c + r] == (j > 1 ? a[3 * r + c] : a[3 * c + r]));
      }
    });
  }
}

TEST_CASE("rows in another order are those of the matrix moved, and failures are named by its rows") {
  BlockMatrix matrix =
      test::spd_matrix(BlockPattern::from_pairs(5, {{0, 1}, {1, 2}, {1, 3}, {1, 4}, {3, 4}}), 5);
  const std::vector<int32_t> order = {3, 1, 4, 0, 2};
  ThreadPool pool(2);
  ExpandedMatrix rows(ExpandedMatrix::Above::Ascending);
  REQUIRE(rows.prepare(matrix, PcgStorage::Double, pool, order));
  CHECK(rows.source_row(2) == 4);
  // Row 1 is row 1 there: its columns 0, 2, 3, 4 are 3, 4, 0, 2 here.
  CHECK(std::vector<int32_t>(rows.column() + rows.row_begin(1), rows.column() + rows.row_end(1)) ==
        std::vector<int32_t>{3, 4, 0, 2});
  rows.with_blocks([&](const auto* blocks) {
    const double* a = matrix.values.data() + 9 * matrix.pattern.slot(1, 4);
    const int64_t k = rows.row_begin(2);  // block (4, 1)
    for (int r = 0; r < 3; ++r)
      for (int c = 0; c < 3; ++c) CHECK(blocks[9 * k + 3 * c + r] == a[3 * c + r]);
  });
  for (const int32_t broken : {4, 3}) matrix.values[9 * matrix.pattern.row_start[broken]] = -1.0;
  CHECK_FALSE(rows.prepare(matrix, PcgStorage::Double, pool, order));
  CHECK(rows.failed_block() == 3);
}
