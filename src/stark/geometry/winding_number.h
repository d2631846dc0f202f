// Generalised winding numbers: how often a surface goes around a point, 1 inside of a closed one that is
// oriented outwards and 0 outside; of surfaces with holes numbers in between, above one half inside
// [Jacobson, Kavan, Sorkine-Hornung 2013]. Far triangles count together, as a dipole [Barill et al. 2018].
// Used while a mesh is made.
#pragma once

#include <span>
#include <vector>

#include <stark/geometry/mesh.h>

namespace stark {

class WindingNumber {
 public:
  /// Takes a copy; degenerate triangles count nothing.
  WindingNumber(std::span<const Vec3> vertices, std::span<const Index3> triangles);
  double at(const Vec3& point) const;

 private:
  struct Node {
    Vec3 centre, area;            ///< mean by area [m], sum of area vectors [m^2]
    double reach = 0.0;           ///< of the farthest vertex from the centre [m]
    int32_t first = 0, last = 0;  ///< triangles below
    int32_t right = -1;           ///< second child, -1 of leaves; the first child follows its parent
  };
  void build(int32_t first, int32_t last);

  std::vector<std::array<Vec3, 3>> triangles_;
  std::vector<Node> nodes_;
};

}  // namespace stark
