// Bindings of geometry and collision: shapes, connectivity, mass properties, distances, continuous detection
// and intersections. Arrays in, arrays out; nothing here decides anything.
#include <stark/collision/collision_set.h>
#include <stark/geometry/closest.h>
#include <stark/geometry/distance.h>
#include <stark/geometry/mass_properties.h>
#include <stark/geometry/shapes.h>
#include <stark/geometry/topology.h>

#include "functions.h"

namespace stark::bindings {

namespace {

constexpr const char* kVertices = "vertices?: an (n, 3) array of numbers [m]";
constexpr const char* kTriangles = "triangles?: an (n, 3) array of vertex indices";

/// (n, 3 points) array: n stencils of so many points each.
template <size_t points>
std::vector<std::array<Vec3, points>> stencils(nb::handle object, const char* name) {
  return from_array<std::vector<std::array<Vec3, points>>>(
      object, std::string(name) + "?: an (n, " + std::to_string(3 * points) +
                  ") array of numbers [m]: " + std::to_string(points) + " points a row");
}

/// The closest features of each row: their type numbers, squared distances and weights.
template <size_t points, typename Weights, typename... Args>
void def_classify(nb::module_& m, const char* name, auto type_of, auto squared_distance,
                  Weights (*weights_of)(Args...)) {
  const auto classify = [=](nb::handle object) {
    std::vector<uint8_t> types;
    std::vector<double> distances;
    std::vector<Weights> weights;
    for (const auto& x : stencils<points>(object, "stencils")) {
      const auto type = std::apply(type_of, x);
      const auto typed = std::tuple_cat(x, std::tuple(type));
      types.push_back(static_cast<uint8_t>(type));
      distances.push_back(std::apply(squared_distance, typed));
      weights.push_back(std::apply(weights_of, typed));
    }
    return std::tuple(types, distances, weights);
  };
  def(m, name, classify, {"stencils"});
}

using Points4 = std::array<Vec3, 4>;
/// Safe fraction of the linear motion x0 -> x1 for each row of vertex coordinates.
void def_ccd(nb::module_& m, const char* name,
             double (*ccd)(const Points4&, const Points4&, double, const CcdSettings&)) {
  const auto safe_fractions = [ccd](nb::handle start, nb::handle end, double min_separation, double margin) {
    const auto x0 = stencils<4>(start, "x0"), x1 = stencils<4>(end, "x1");
    if (x0.size() != x1.size()) throw InvalidArgument("x0 and x1 have different numbers of rows");
    CcdSettings settings;
    settings.time_margin = margin;
    std::vector<double> steps(x0.size());
    for (size_t k = 0; k < x0.size(); ++k) steps[k] = ccd(x0[k], x1[k], min_separation, settings);
    return steps;
  };
  def(m, name, safe_fractions,
      {"x0", "x1", {"min_separation", 0.0}, {"time_margin", CcdSettings().time_margin}});
}

void bind_shapes(nb::module_& m) {
  const Argument radius("radius"), height("height"), size("size"), segments("segments", 32);
  def<make_grid>(m, {"size_x", "size_y", "cells_x", "cells_y"});
  def<make_box>(m, {size, {"subdivisions", 1}});
  def<make_icosphere>(m, {radius, "subdivisions"});
  def<make_cylinder>(m, {radius, height, segments, {"stacks", 1}});
  def<make_capsule>(m, {radius, height, segments, {"rings", 8}});
  def<make_torus>(m, {"major_radius", "minor_radius", {"major_segments", 48}, {"minor_segments", 24}});
  def<make_tet_box>(m, {size, "cells"});
}

/// The triangle closest to each point, and its distance [m].
auto closest_triangles(std::span<const Vec3> points, std::span<const Vec3> vertices,
                       std::span<const Index3> triangles) {
  std::vector<int32_t> indices;
  std::vector<double> distances;
  for (const ClosestTriangle& c : find_closest_triangles(points, vertices, triangles)) {
    indices.push_back(c.triangle);
    distances.push_back(c.distance);
  }
  return std::pair(indices, distances);
}

MassProperties solid_mass_properties(const std::vector<Vec3>& vertices, const std::vector<Index3>& triangles,
                                     double density) {
  validate(TriangleMesh{vertices, triangles}, "mesh");
  return compute_solid_mass_properties(vertices, triangles, density);
}

void bind_topology(nb::module_& m) {
  using EdgesOfTriangles = std::vector<Index2> (*)(std::span<const Index3>);
  using EdgesOfTets = std::vector<Index2> (*)(std::span<const Index4>);
  def<static_cast<EdgesOfTriangles>(find_edges), find_hinges, find_boundary_edges, is_closed>(m,
                                                                                              {kTriangles});
  def(m, "find_tet_edges", static_cast<EdgesOfTets>(find_edges),
      {"tets?: an (n, 4) array of vertex indices"});
  def(m, "find_closest_triangles", closest_triangles,
      {"points: an (n, 3) array", "vertices: an (n, 3) array", kTriangles});
  def(m, "compute_solid_mass_properties", solid_mass_properties, {kVertices, kTriangles, "density"});
}

void bind_distances(nb::module_& m) {
  // The forms that take a type found before.
  const auto point_edge = [](const auto&... x) { return point_edge_squared_distance(x...); };
  const auto point_triangle = [](const auto&... x) { return point_triangle_squared_distance(x...); };
  const auto edge_edge = [](const auto&... x) { return edge_edge_squared_distance(x...); };
  def_classify<3>(m, "classify_point_edge", point_edge_type, point_edge, point_edge_weights);
  def_classify<4>(m, "classify_point_triangle", point_triangle_type, point_triangle, point_triangle_weights);
  def_classify<4>(m, "classify_edge_edge", edge_edge_type, edge_edge, edge_edge_weights);
  def_ccd(m, "point_triangle_ccd", point_triangle_ccd);
  def_ccd(m, "edge_edge_ccd", edge_edge_ccd);
}

void make_set(CollisionSet* self, const std::vector<int32_t>& vertex_group, const std::vector<Index2>& edges,
              const std::vector<Index3>& triangles, const std::vector<int32_t>& points,
              const std::vector<Index2>& excluded, int threads) {
  new (self) CollisionSet(vertex_group, edges, triangles, points, excluded, threads);
}

/// The safe fraction of a motion, and the pair that limits it: its kind and numbers.
auto max_safe_step(CollisionSet& set, std::span<const Vec3> x0, std::span<const Vec3> x1,
                   std::span<const double> separation) {
  const CcdReport report = set.max_safe_step(x0, x1, separation);
  const std::string kind = report.kind ? std::string(to_string(*report.kind)) : "";
  return std::tuple(report.step, kind, report.first, report.second);
}

void bind_collision(nb::module_& m) {
  nb::class_<CollisionSet> set(m, "CollisionScene",
                               "Collision primitives of groups of vertices and what may touch.");
  const Argument points("points: an (n,) array of vertex indices", nb::tuple());
  const Argument excluded("excluded_pairs?: an (n, 2) array of groups", nb::tuple());
  def(set, "__init__", make_set,
      {"vertex_group: an (n,) array of group numbers",
       "edges?: an (n, 2) array of vertex indices",
       kTriangles,
       points,
       excluded,
       {"threads", 1}});
  def<max_safe_step>(set, {"x0?: an (n, 3) array of numbers [m]", "x1?: an (n, 3) array of numbers [m]",
                           "separation: one number [m] for each group"});
  using Set = CollisionSet;
  def<&Set::find_intersections, &Set::find_contained_groups>(set, {"x?: an (n, 3) array of numbers [m]"});
}

}  // namespace

void bind_geometry(nb::module_& m) {
  bind_shapes(m);
  bind_topology(m);
  bind_distances(m);
  bind_collision(m);
}

}  // namespace stark::bindings
