// How near pairs of edges must be to push (step phase 4b).
//
// Where surfaces are flat, vertices carry the pressure and edges add nothing to it: pairs of edges are a
// barrier, which acts within a tenth of the contact distance only. Where surfaces are sharp, edges carry what
// vertices do not, from the whole contact distance on. With the flatness f of an edge, 1 flat, 0 sharp, and
// rho = 0.1 the part is rho^((f_a + f_b)/2) between closed surfaces and rho^(f_a f_b) where one is a sheet,
// which has nothing else to hang over an edge by. A rod has no flat sides. [theory eq. 16b]
#pragma once

#include <cmath>
#include <cstdint>
#include <span>
#include <vector>

namespace stark {

class EdgeRanges {
 public:
  struct Edge {
    double flatness = 0.0;  ///< 0 sharp, 1 flat; of sheets 1, or 0.5 at borders
    bool is_sheet = false, is_rod = false;
  };

  EdgeRanges() = default;
  explicit EdgeRanges(std::span<const Edge> edges);

  /// Part of the contact distance of two edges within which they act.
  double operator()(int32_t a, int32_t b) const {
    if (parts_.empty()) return 1.0;
    const Parts &of_a = parts_[a], &of_b = parts_[b];
    if (of_a.edge.is_rod || of_b.edge.is_rod) return 1.0;
    if (!of_a.edge.is_sheet && !of_b.edge.is_sheet) return of_a.half * of_b.half;
    const Parts &sheet = of_a.edge.is_sheet ? of_a : of_b, &other = of_a.edge.is_sheet ? of_b : of_a;
    return sheet.edge.flatness == 1.0 ? other.whole : std::pow(other.whole, sheet.edge.flatness);
  }

 private:
  struct Parts {
    Edge edge;
    double whole = 1.0, half = 1.0;  ///< rho to the power f, and f/2
  };
  std::vector<Parts> parts_;
};

}  // namespace stark
