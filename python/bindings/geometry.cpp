// Bindings of geometry and collision: shapes, connectivity, mass properties, distances, continuous detection,
// candidates and intersections. Arrays in, arrays out; nothing here decides anything.
#include <nanobind/nanobind.h>
#include <nanobind/ndarray.h>
#include <nanobind/stl/array.h>
#include <nanobind/stl/pair.h>
#include <nanobind/stl/string.h>
#include <nanobind/stl/tuple.h>
#include <nanobind/stl/vector.h>

#include <array>
#include <string>
#include <tuple>
#include <utility>
#include <vector>

#include <stark/collision/collision_set.h>
#include <stark/geometry/closest.h>
#include <stark/geometry/distance.h>
#include <stark/geometry/intersection.h>
#include <stark/geometry/mass_properties.h>
#include <stark/geometry/shapes.h>
#include <stark/geometry/topology.h>

#include "domains.h"
#include "with_arrays.h"

namespace nb = nanobind;
using namespace nb::literals;
using namespace stark;
using namespace stark::bindings;

template <>
struct stark::bindings::NumbersOf<PrimitivePair> : NumbersOf<Index2> {};
template <>
struct stark::bindings::NumbersOf<EdgeTriangleIntersection> : NumbersOf<Index2> {};
template <>
struct stark::bindings::NumbersOf<ContainedGroup> : NumbersOf<Index3> {};
template <size_t n>
struct stark::bindings::NumbersOf<std::array<Vec3, n>> : NumbersOf<Vec3> {};

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

auto to_arrays(TriangleMesh mesh) {
  return std::pair(to_numpy(std::move(mesh.vertices)), to_numpy(std::move(mesh.triangles)));
}
auto to_arrays(TetMesh mesh) {
  return std::pair(to_numpy(std::move(mesh.vertices)), to_numpy(std::move(mesh.tets)));
}

std::array<double, 3> triple(const Vec3& v) { return {v.x, v.y, v.z}; }

template <auto function>
nb::dict mass_properties(std::span<const Vec3> vertices, std::span<const Index3> triangles, double density) {
  const MassProperties p = function(vertices, triangles, density);
  return dict_of("measure", p.measure, "mass", p.mass, "centre", triple(p.centre), "inertia", p.inertia);
}

// (n, 3 Vertices) array: n stencils of so many vertices each.
template <size_t Vertices>
std::vector<std::array<Vec3, Vertices>> stencils(nb::handle object, const char* name) {
  return from_array<std::vector<std::array<Vec3, Vertices>>>(
      object, std::string(name) + "?: an (n, " + std::to_string(3 * Vertices) +
                  ") array of numbers [m]: " + std::to_string(Vertices) + " points a row");
}

// Type, squared distance and weights of each row.
template <size_t vertices, typename Classify>
auto classify(nb::handle object, Classify classify_row) {
  using Row = decltype(classify_row(std::array<Vec3, vertices>{}));
  std::vector<uint8_t> types;
  std::vector<double> distances;
  std::vector<std::tuple_element_t<2, Row>> weights;
  for (const auto& x : stencils<vertices>(object, "stencils")) {
    const auto& [type, distance, weight] = classify_row(x);
    types.push_back(static_cast<uint8_t>(type));
    distances.push_back(distance);
    weights.push_back(weight);
  }
  return std::tuple(to_numpy(std::move(types)), to_numpy(std::move(distances)), to_numpy(std::move(weights)));
}

template <size_t vertices>
void def_ccd(nb::module_& m, const char* name,
             double (*function)(const std::array<Vec3, vertices>&, const std::array<Vec3, vertices>&, double,
                                const CcdSettings&)) {
  m.def(
      name,
      [function](nb::handle start, nb::handle end, double min_separation, double time_margin) {
        const auto x0 = stencils<vertices>(start, "x0"), x1 = stencils<vertices>(end, "x1");
        if (x0.size() != x1.size()) throw InvalidArgument("x0 and x1 have different numbers of rows");
        CcdSettings settings;
        settings.time_margin = time_margin;
        std::vector<double> steps(x0.size());
        for (size_t k = 0; k < x0.size(); ++k) steps[k] = function(x0[k], x1[k], min_separation, settings);
        return to_numpy(std::move(steps));
      },
      "x0"_a, "x1"_a, "min_separation"_a = 0.0, "time_margin"_a = CcdSettings{}.time_margin,
      "Safe fraction of the linear motion x0 -> x1 for each row of vertex coordinates.");
}

nb::dict find_pairs(CollisionSet& set, std::span<const Vec3> x0, std::span<const Vec3> x1,
                    std::span<const double> inflation) {
  CandidateList list = set.find(x0, x1, inflation);
  nb::dict result;
  for_each_pair_kind([&](auto kind) {
    result[nb::str(PairRow<kind.value>::kName.data())] = to_numpy(std::move(list[kind]));
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

/// A function that makes a mesh, as arrays.
template <auto make>
struct Making;
template <typename Mesh, typename... Args, Mesh (*make)(Args...)>
struct Making<make> {
  static auto arrays(Args... args) { return to_arrays(make(args...)); }
};
template <auto make>
constexpr auto arrays_of = &Making<make>::arrays;

void bind_shapes(nb::module_& m) {
  m.def("make_grid", arrays_of<make_grid>, "size_x"_a, "size_y"_a, "cells_x"_a, "cells_y"_a);
  m.def("make_box", arrays_of<make_box>, "size"_a, "subdivisions"_a = 1);
  m.def("make_icosphere", arrays_of<make_icosphere>, "radius"_a, "subdivisions"_a);
  m.def("make_cylinder", arrays_of<make_cylinder>, "radius"_a, "height"_a, "segments"_a = 32, "stacks"_a = 1);
  m.def("make_capsule", arrays_of<make_capsule>, "radius"_a, "height"_a, "segments"_a = 32, "rings"_a = 8);
  m.def("make_torus", arrays_of<make_torus>, "major_radius"_a, "minor_radius"_a, "major_segments"_a = 48,
        "minor_segments"_a = 24);
  m.def("make_tet_box", arrays_of<make_tet_box>, "size"_a, "cells"_a);
}

nb::tuple closest_triangles(std::span<const Vec3> points, std::span<const Vec3> vertices,
                            std::span<const Index3> triangles) {
  std::vector<int32_t> indices;
  std::vector<double> distances;
  for (const ClosestTriangle& c : find_closest_triangles(points, vertices, triangles)) {
    indices.push_back(c.triangle);
    distances.push_back(c.distance);
  }
  return nb::make_tuple(to_numpy(std::move(indices)), to_numpy(std::move(distances)));
}

auto principal_axes(const std::vector<Vec3>& a) {
  if (a.size() != 3) throw InvalidArgument("matrix: must be a symmetric (3, 3) array");
  const PrincipalAxes p = compute_principal_axes(transpose(Mat3::from_columns(a[0], a[1], a[2])));
  return std::pair(triple(p.values), nb::cast(p.axes));
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
  constexpr auto solid = mass_properties<compute_solid_mass_properties>;
  constexpr auto shell = mass_properties<compute_shell_mass_properties>;
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
  m.def("compute_solid_mass_properties", with_arrays<of_mesh<solid, double>, kVertices, kTriangles>,
        "vertices"_a, "triangles"_a, "density"_a);
  m.def("compute_shell_mass_properties", with_arrays<of_mesh<shell, double>, kVertices, kTriangles>,
        "vertices"_a, "triangles"_a, "area_density"_a);
  m.def("compute_principal_axes", with_arrays<principal_axes, "matrix?: a symmetric (3, 3) array">,
        "matrix"_a);
}

void bind_distances(nb::module_& m) {
  using S3 = std::array<Vec3, 3>;
  using S4 = std::array<Vec3, 4>;
  constexpr const char* kDoc =
      "Closest features (type numbers), squared distances and weights, one stencil a row.";
  const auto point_edge = [](const S3& s) {
    const PointEdgeType t = point_edge_type(s[0], s[1], s[2]);
    return std::tuple(t, point_edge_squared_distance(s[0], s[1], s[2], t),
                      point_edge_weights(s[0], s[1], s[2], t));
  };
  const auto point_triangle = [](const S4& s) {
    const PointTriangleType t = point_triangle_type(s[0], s[1], s[2], s[3]);
    return std::tuple(t, point_triangle_squared_distance(s[0], s[1], s[2], s[3], t),
                      point_triangle_weights(s[0], s[1], s[2], s[3], t));
  };
  const auto edge_edge = [](const S4& s) {
    const EdgeEdgeType t = edge_edge_type(s[0], s[1], s[2], s[3]);
    return std::tuple(t, edge_edge_squared_distance(s[0], s[1], s[2], s[3], t),
                      edge_edge_weights(s[0], s[1], s[2], s[3], t));
  };
  const auto def_classify = [&](const char* name, auto vertices, auto classify_row) {
    m.def(name, [=](nb::handle x) { return classify<vertices.value>(x, classify_row); }, "stencils"_a, kDoc);
  };
  def_classify("classify_point_edge", std::integral_constant<size_t, 3>(), point_edge);
  def_classify("classify_point_triangle", std::integral_constant<size_t, 4>(), point_triangle);
  def_classify("classify_edge_edge", std::integral_constant<size_t, 4>(), edge_edge);
  def_ccd<2>(m, "point_point_ccd", point_point_ccd);
  def_ccd<3>(m, "point_edge_ccd", point_edge_ccd);
  def_ccd<4>(m, "point_triangle_ccd", point_triangle_ccd);
  def_ccd<4>(m, "edge_edge_ccd", edge_edge_ccd);
  m.def("orient3d", orient3d, "a"_a, "b"_a, "c"_a, "d"_a);
  m.def(
      "segment_intersects_triangle",
      [](nb::handle stencil_rows) {
        std::vector<uint8_t> hits;
        for (const auto& s : stencils<5>(stencil_rows, "stencils")) {
          hits.push_back(segment_intersects_triangle(s[0], s[1], s[2], s[3], s[4]));
        }
        return to_numpy(std::move(hits));
      },
      "stencils"_a,
      "1 where the segment (first two points of the row) meets the triangle (the other three).");
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
