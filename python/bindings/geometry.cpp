// Bindings of geometry and collision: shapes, connectivity, mass properties, distances, continuous detection,
// candidates and intersections. Arrays in, arrays out; nothing here decides anything.
#include <tuple>

#include <stark/collision/collision_set.h>
#include <stark/geometry/closest.h>
#include <stark/geometry/distance.h>
#include <stark/geometry/intersection.h>
#include <stark/geometry/mass_properties.h>
#include <stark/geometry/shapes.h>
#include <stark/geometry/topology.h>

#include "with_arrays.h"

namespace stark::bindings {

template <>
struct NumbersOf<PrimitivePair> : NumbersOf<Index2> {};
template <>
struct NumbersOf<EdgeTriangleIntersection> : NumbersOf<Index2> {};
template <>
struct NumbersOf<ContainedGroup> : NumbersOf<Index3> {};
template <size_t n>
struct NumbersOf<std::array<Vec3, n>> : NumbersOf<Vec3> {};

template <>
inline constexpr int kMembers<TriangleMesh> = 2;
template <>
inline constexpr int kMembers<TetMesh> = 2;
template <>
inline constexpr int kMembers<PrincipalAxes> = 2;

namespace {

constexpr Text kVertices = "vertices?: an (n, 3) array of numbers [m]";
constexpr Text kTriangles = "triangles?: an (n, 3) array of vertex indices";
constexpr Text kTets = "tets?: an (n, 4) array of vertex indices";

/// A function of vertices and triangles, whose indices are checked.
template <auto function, typename... More>
auto of_mesh(const std::vector<Vec3>& vertices, const std::vector<Index3>& triangles, More... more) {
  validate(TriangleMesh{vertices, triangles}, "mesh");
  return function(vertices, triangles, more...);
}

/// (n, 3 points) array: n stencils of so many points each.
template <size_t points>
std::vector<std::array<Vec3, points>> stencils(nb::handle object, const char* name) {
  return from_array<std::vector<std::array<Vec3, points>>>(
      object, std::string(name) + "?: an (n, " + std::to_string(3 * points) +
                  ") array of numbers [m]: " + std::to_string(points) + " points a row");
}

/// The closest features of each row: their type, squared distance and weights.
template <size_t points>
void def_classify(nb::module_& m, const char* name, auto type_of, auto squared_distance, auto weights_of) {
  using Weights = typename SignatureOf<decltype(weights_of)>::result;
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
    return std::tuple(ArrayOf{types}, ArrayOf{distances}, ArrayOf{weights});
  };
  m.def(name, classify, "stencils"_a,
        "Closest features (type numbers), squared distances and weights, one stencil a row.");
}

using Points4 = std::array<Vec3, 4>;
void def_ccd(nb::module_& m, const char* name,
             double (*ccd)(const Points4&, const Points4&, double, const CcdSettings&)) {
  const auto safe_fractions = [ccd](nb::handle start, nb::handle end, double min_separation, double margin) {
    const auto x0 = stencils<4>(start, "x0"), x1 = stencils<4>(end, "x1");
    if (x0.size() != x1.size()) throw InvalidArgument("x0 and x1 have different numbers of rows");
    CcdSettings settings;
    settings.time_margin = margin;
    std::vector<double> steps(x0.size());
    for (size_t k = 0; k < x0.size(); ++k) steps[k] = ccd(x0[k], x1[k], min_separation, settings);
    return ArrayOf{steps};
  };
  m.def(name, safe_fractions, "x0"_a, "x1"_a, "min_separation"_a = 0.0,
        "time_margin"_a = CcdSettings{}.time_margin,
        "Safe fraction of the linear motion x0 -> x1 for each row of vertex coordinates.");
}

nb::dict find_pairs(CollisionSet& set, std::span<const Vec3> x0, std::span<const Vec3> x1,
                    std::span<const double> inflation) {
  CandidateList list = set.find(x0, x1, inflation);
  nb::dict result;
  for_each_pair_kind([&](auto kind) {
    result[nb::str(PairRow<kind.value>::kName.data())] = ArrayOf{std::move(list[kind])};
  });
  return result;
}

std::tuple<double, std::string, int, int> safe_step(CollisionSet& set, std::span<const Vec3> x0,
                                                    std::span<const Vec3> x1,
                                                    std::span<const double> separation) {
  const CcdReport report = set.max_safe_step(x0, x1, separation);
  return {report.step, report.kind ? std::string(to_string(*report.kind)) : "", report.first, report.second};
}

void make_set(CollisionSet* self, const std::vector<int32_t>& vertex_group, const std::vector<Index2>& edges,
              const std::vector<Index3>& triangles, const std::vector<int32_t>& points,
              const std::vector<Index2>& excluded, int threads) {
  new (self) CollisionSet(vertex_group, edges, triangles, points, excluded, threads);
}

void bind_shapes(nb::module_& m) {
  m.def("make_grid", make_grid, "size_x"_a, "size_y"_a, "cells_x"_a, "cells_y"_a);
  m.def("make_box", make_box, "size"_a, "subdivisions"_a = 1);
  m.def("make_icosphere", make_icosphere, "radius"_a, "subdivisions"_a);
  m.def("make_cylinder", make_cylinder, "radius"_a, "height"_a, "segments"_a = 32, "stacks"_a = 1);
  m.def("make_capsule", make_capsule, "radius"_a, "height"_a, "segments"_a = 32, "rings"_a = 8);
  m.def("make_torus", make_torus, "major_radius"_a, "minor_radius"_a, "major_segments"_a = 48,
        "minor_segments"_a = 24);
  m.def("make_tet_box", make_tet_box, "size"_a, "cells"_a);
}

nb::tuple closest_triangles(std::span<const Vec3> points, std::span<const Vec3> vertices,
                            std::span<const Index3> triangles) {
  std::vector<int32_t> indices;
  std::vector<double> distances;
  for (const ClosestTriangle& c : find_closest_triangles(points, vertices, triangles)) {
    indices.push_back(c.triangle);
    distances.push_back(c.distance);
  }
  return nb::make_tuple(ArrayOf{indices}, ArrayOf{distances});
}

std::vector<int32_t> components(std::span<const Vec3> vertices, std::span<const Index3> triangles) {
  return find_connected_components(static_cast<int32_t>(vertices.size()), triangles);
}

std::vector<uint8_t> locate_points(const std::vector<Vec3>& points, const std::vector<Vec3>& vertices,
                                   const std::vector<Index3>& triangles) {
  validate(TriangleMesh{vertices, triangles}, "mesh");
  std::vector<uint8_t> locations;
  for (const Vec3& point : points)
    locations.push_back(static_cast<uint8_t>(locate_point(point, vertices, triangles)));
  return locations;
}

void bind_topology(nb::module_& m) {
  using EdgesOfTriangles = std::vector<Index2> (*)(std::span<const Index3>);
  using EdgesOfTets = std::vector<Index2> (*)(std::span<const Index4>);
  using Boundary = std::vector<Index3> (*)(std::span<const Index4>);
  m.def("find_edges", with_arrays<static_cast<EdgesOfTriangles>(find_edges), kTriangles>, "triangles"_a);
  m.def("find_tet_edges", with_arrays<static_cast<EdgesOfTets>(find_edges), kTets>, "tets"_a);
  m.def("find_closest_triangles",
        with_arrays<closest_triangles, "points: an (n, 3) array", "vertices: an (n, 3) array", kTriangles>,
        "points"_a, "vertices"_a, "triangles"_a, "(triangle closest to each point, distance [m]).");
  m.def("find_hinges", with_arrays<find_hinges, kTriangles>, "triangles"_a);
  m.def("find_boundary_edges", with_arrays<find_boundary_edges, kTriangles>, "triangles"_a);
  m.def("find_boundary_triangles", with_arrays<static_cast<Boundary>(find_boundary_triangles), kTets>,
        "tets"_a);
  m.def("find_connected_components", with_arrays<of_mesh<components>, kVertices, kTriangles>, "vertices"_a,
        "triangles"_a);
  m.def("is_closed", with_arrays<is_closed, kTriangles>, "triangles"_a);
  m.def("is_orientation_consistent", with_arrays<is_orientation_consistent, kTriangles>, "triangles"_a);
  m.def("compute_vertex_areas", with_arrays<of_mesh<compute_vertex_areas>, kVertices, kTriangles>,
        "vertices"_a, "triangles"_a);
  m.def("compute_solid_mass_properties",
        with_arrays<of_mesh<compute_solid_mass_properties, double>, kVertices, kTriangles>, "vertices"_a,
        "triangles"_a, "density"_a);
  m.def("compute_principal_axes", with_arrays<compute_principal_axes, "matrix: a symmetric (3, 3) array">,
        "matrix"_a);
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
  m.def("locate_points",
        with_arrays<locate_points, "points?: an (n, 3) array of numbers [m]", kVertices, kTriangles>,
        "points"_a, "vertices"_a, "triangles"_a, "0 outside, 1 inside, 2 on the closed surface.");
}

void bind_collision(nb::module_& m) {
  constexpr Text x = "x?: an (n, 3) array of numbers [m]";
  constexpr Text x0 = "x0?: an (n, 3) array of numbers [m]";
  constexpr Text x1 = "x1?: an (n, 3) array of numbers [m]";
  nb::class_<CollisionSet>(m, "CollisionScene",
                           "Collision primitives of groups of vertices and what may touch.")
      .def("__init__",
           with_arrays<make_set, "vertex_group: an (n,) array of group numbers",
                       "edges?: an (n, 2) array of vertex indices", kTriangles,
                       "points: an (n,) array of vertex indices",
                       "excluded_pairs?: an (n, 2) array of groups">,
           "vertex_group"_a, "edges"_a, "triangles"_a, "points"_a = nb::tuple(),
           "excluded_pairs"_a = nb::tuple(), "threads"_a = 1)
      .def("find", with_arrays<find_pairs, x0, x1, "inflation: one number [m] for each group">, "x0"_a,
           "x1"_a, "inflation"_a,
           "Candidate pairs for the linear motion x0 -> x1 with boxes inflated by each group's value [m].")
      .def("max_safe_step", with_arrays<safe_step, x0, x1, "separation: one number [m] for each group">,
           "x0"_a, "x1"_a, "separation"_a,
           "(step, kind, first, second): safe fraction of the motion and the pair that limits it.")
      .def("find_intersections", with_arrays<&CollisionSet::find_intersections, x>, "x"_a,
           "(n, 2): edges and triangles that meet.")
      .def("find_contained_groups", with_arrays<&CollisionSet::find_contained_groups, x>, "x"_a,
           "(n, 3): inner group, outer group, vertex of the inner one.");
}

}  // namespace

void bind_geometry(nb::module_& m) {
  bind_shapes(m);
  bind_topology(m);
  bind_distances(m);
  bind_collision(m);
}

}  // namespace stark::bindings
