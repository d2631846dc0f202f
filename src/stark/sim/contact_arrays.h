// Contacts of the last step as arrays with a row each, for whoever reads them all at once. Phase: queries.
#pragma once

#include <array>
#include <vector>

#include <stark/sim/simulation.h>

namespace stark {

/// Forces are on the first body of a row.
struct ContactArrays {
  std::vector<Index2> bodies;
  std::vector<Index4> vertices;                ///< of the meshes of their bodies, -1 where there are fewer
  std::vector<std::array<double, 4>> weights;  ///< separation = sum_i weights_i x_i
  std::vector<int32_t> first_counts;           ///< so many vertices belong to the first body
  std::vector<double> distances;               ///< [m]
  std::vector<Vec3> points_a, points_b;        ///< closest points [m]
  std::vector<Vec3> friction_points;           ///< where friction acts on side A [m]
  std::vector<Vec3> friction_points_b;         ///< on side B [m]
  std::vector<Vec3> normal_forces, frictions;  ///< [N]
  std::vector<Vec3> slips;  ///< tangential velocity of the first body against the other [m/s]

  /// Calls function(name, array) with each array.
  template <typename Function>
  void for_each(Function&& function) {
    function("bodies", bodies);
    function("vertices", vertices);
    function("weights", weights);
    function("first_counts", first_counts);
    function("distances", distances);
    function("points_a", points_a);
    function("points_b", points_b);
    function("friction_points", friction_points);
    function("friction_points_b", friction_points_b);
    function("normal_forces", normal_forces);
    function("frictions", frictions);
    function("slips", slips);
  }
};

ContactArrays contact_arrays(const Simulation& simulation);

/// Vertices of a rigid body inside of its flat faces, where contact never acts.
std::vector<int32_t> inner_vertices(const Simulation& simulation, BodyId body);

/// Edges of a surface and of its triangles, those included that contact leaves out of flat faces.
std::vector<Index2> all_edges(const SurfaceMesh& mesh);

}  // namespace stark
