#include <stark/sim/contact_arrays.h>

#include <algorithm>
#include <span>

#include <stark/geometry/topology.h>

namespace stark {

ContactArrays contact_arrays(const Simulation& simulation) {
  ContactArrays rows;
  for (const ContactForce& entry : simulation.contacts()) {
    const Contact& contact = entry.contact;
    rows.bodies.push_back({contact.group_a, contact.group_b});
    rows.first_counts.push_back(contact.side_a_count);
    Index4& own = rows.vertices.emplace_back(Index4{-1, -1, -1, -1});
    std::array<double, 4>& weights = rows.weights.emplace_back();
    for (int p = 0; p < contact.point_count; ++p) {
      const int32_t group = p < contact.side_a_count ? contact.group_a : contact.group_b;
      own[p] = contact.sites[p] - simulation.model().bodies()[group].first_site;
      weights[p] = contact.weights[p];
    }
    rows.distances.push_back(contact.distance);
    rows.points_a.push_back(entry.point_a);
    rows.points_b.push_back(entry.point_b);
    rows.friction_points.push_back(entry.friction_point);
    rows.friction_points_b.push_back(entry.friction_at.is_carried() ? entry.friction_point : entry.point_b);
    rows.normal_forces.push_back(entry.normal_force);
    rows.frictions.push_back(entry.friction);
    rows.slips.push_back(entry.slip);
  }
  return rows;
}

std::vector<int32_t> inner_vertices(const Simulation& simulation, BodyId body) {
  const SurfaceMesh& mesh = simulation.surface_mesh();
  const int32_t first = simulation.model().bodies()[body.index].first_site;
  std::vector<int32_t> inner;
  for (const int32_t v : mesh.inner)
    if (mesh.vertex_group[v] == body.index) inner.push_back(v - first);
  return inner;
}

std::vector<Index2> all_edges(const SurfaceMesh& mesh) {
  std::vector<Index2> edges = find_edges(std::span<const Index3>(mesh.triangles));
  const auto of_triangles = static_cast<std::ptrdiff_t>(edges.size());
  for (const Index2& e : mesh.edges)
    if (!std::binary_search(edges.begin(), edges.begin() + of_triangles, e)) edges.push_back(e);
  return edges;
}

}  // namespace stark
