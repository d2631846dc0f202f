#include <stark/contact/edge_ranges.h>

namespace stark {

namespace {

/// Part of the contact distance within which edges push where both surfaces are flat.
constexpr double kFlatRange = 0.1;

}  // namespace

EdgeRanges::EdgeRanges(std::span<const Edge> edges) {
  for (const Edge& edge : edges) {
    const double whole = std::pow(kFlatRange, edge.flatness);
    parts_.push_back({.edge = edge, .whole = whole, .half = std::sqrt(whole)});
  }
}

}  // namespace stark
