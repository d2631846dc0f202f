// Numbering of unknowns: prescribed points and bodies have none.
#include <doctest/doctest.h>

#include <stark/mechanics/dof_layout.h>

using namespace stark;

TEST_CASE("free points come first, then free bodies with two blocks each") {
  const DofLayout layout = DofLayout::build({false, true, false, true}, {true, false, false});
  CHECK(layout.point_block == std::vector<int32_t>{0, kNoBlock, 1, kNoBlock});
  CHECK(layout.body_block == std::vector<int32_t>{kNoBlock, 2, 4});
  CHECK(layout.block_count == 6);
}

TEST_CASE("translation and rotation are prescribed one without the other") {
  const DofLayout layout = DofLayout::build({false}, {false, true, true, false}, {true, false, true, false});
  CHECK(layout.body_block == std::vector<int32_t>{1, kNoBlock, kNoBlock, 3});
  CHECK(layout.rotation_block == std::vector<int32_t>{kNoBlock, 2, kNoBlock, 4});
  CHECK(layout.block_count == 5);
}

TEST_CASE("a scene of prescribed parts has no unknowns") {
  const DofLayout layout = DofLayout::build({true, true}, {true});
  CHECK(layout.block_count == 0);
  CHECK(layout.point_block == std::vector<int32_t>{kNoBlock, kNoBlock});
  CHECK(DofLayout::build({}, {}).block_count == 0);
}
