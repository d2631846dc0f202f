// Finds edges of a mesh by their two vertices. Used while a scene is built.
#pragma once

#include <span>
#include <vector>

#include <stark/geometry/mesh.h>

namespace stark {

class EdgeLookup {
 public:
  /// Edges in any order, each as (a, b) or (b, a). Vertices are not negative.
  explicit EdgeLookup(std::span<const Index2> edges);

  /// The edge between two vertices, the first of several; -1: there is none.
  int32_t find(int32_t a, int32_t b) const;

 private:
  struct Entry {
    int32_t low, high, edge;
  };
  std::vector<Entry> entries_;  // sorted
  std::vector<int64_t> start_;  // of the entries of each lower vertex
};

}  // namespace stark
