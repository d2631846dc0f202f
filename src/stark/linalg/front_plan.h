// Memory layout and task split of a multifrontal factorisation: where every front keeps its part of the
// factor and its update matrix, and which subtrees are factorised as one task. Neither depends on the number
// of threads. Phase: symbolic factorisation.
#pragma once

#include <cstdint>
#include <vector>

#include <stark/linalg/elimination.h>

namespace stark {

struct FrontPlan {
  /// Supernodes [begin, end) are one task: a subtree, or several, factorised by one thread.
  struct Subtree {
    int32_t begin, end;
  };

  std::vector<int64_t> factor_offset;  // [supernode_count + 1] scalars
  std::vector<int64_t> update_offset;  // of the update matrix in its arena
  std::vector<uint8_t> in_subtree;  // 1: supernode of a subtree, 0: above, factorised by all threads together
  std::vector<uint8_t>
      update_shared;  // 1: update matrix in the shared arena, 0: in the arena of the subtree's thread
  std::vector<Subtree> subtrees;  // ascending
  std::vector<int32_t> top;       // supernodes above the subtrees, ascending
  int64_t thread_arena_size = 0;  // scalars, for the largest subtree
  int64_t shared_arena_size = 0;
  int max_rows = 0;  // of a front, in scalars, whole strips

  void build(const AssemblyTree& tree, int strip, int tile);
};

}  // namespace stark
