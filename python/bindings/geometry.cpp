// Bindings of geometry and collision: shapes, connectivity, mass properties, distances, continuous detection,
// candidates and intersections. Arrays in, arrays out; nothing here decides anything.
#include <nanobind/nanobind.h>
#include <nanobind/ndarray.h>
#include <nanobind/stl/array.h>
#include <nanobind/stl/pair.h>
#include <nanobind/stl/string.h>
#include <nanobind/stl/tuple.h>
#include <nanobind/stl/vector.h>

#include <algorithm>
#include <array>
#include <string>
#include <tuple>
#include <utility>
#include <vector>

#include <stark/collision/broad_phase.h>
#include <stark/collision/intersection.h>
#include <stark/collision/max_safe_step.h>
#include <stark/geometry/closest.h>
#include <stark/geometry/distance.h>
#include <stark/geometry/intersection.h>
#include <stark/geometry/mass_properties.h>
#include <stark/geometry/shapes.h>
#include <stark/geometry/topology.h>

#include "casters.h"
#include "domains.h"

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

namespace {

template <typename Value, typename T, long columns>
std::vector<Value> copy(nb::handle object, const char* name, const std::string& expected) {
  if (nb::hasattr(object, "__len__") && nb::len(object) == 0) return {};  // [] has no columns
  return rows_of<Value, T, columns>(object, name, expected);
}

std::vector<Vec3> points(nb::handle object, const char* name) {
  return copy<Vec3, double, 3>(object, name, "an (n, 3) array of numbers [m]");
}
std::vector<Index2> edges(nb::handle object) {
  return copy<Index2, int32_t, 2>(object, "edges", "an (n, 2) array of vertex indices");
}
std::vector<Index3> triangles(nb::handle object) {
  return copy<Index3, int32_t, 3>(object, "triangles", "an (n, 3) array of vertex indices");
}
std::vector<Index4> tets(nb::handle object) {
  return copy<Index4, int32_t, 4>(object, "tets", "an (n, 4) array of vertex indices");
}

TriangleMesh triangle_mesh(nb::handle vertices, nb::handle faces) {
  TriangleMesh mesh{points(vertices, "vertices"), triangles(faces)};
  validate(mesh, "mesh");
  return mesh;
}

auto to_arrays(TriangleMesh mesh) {
  return std::pair(to_numpy(std::move(mesh.vertices)), to_numpy(std::move(mesh.triangles)));
}
auto to_arrays(TetMesh mesh) {
  return std::pair(to_numpy(std::move(mesh.vertices)), to_numpy(std::move(mesh.tets)));
}

std::array<double, 3> triple(const Vec3& v) { return {v.x, v.y, v.z}; }

nb::dict to_dict(const MassProperties& p) {
  return dict_of("measure", p.measure, "mass", p.mass, "centre", triple(p.centre), "inertia", p.inertia);
}

// (n, 3 Vertices) array: n stencils of so many vertices each.
template <size_t Vertices>
std::vector<std::array<Vec3, Vertices>> stencils(nb::handle object, const char* name) {
  const std::string expected = "an (n, " + std::to_string(3 * Vertices) +
                               ") array of numbers [m]: " + std::to_string(Vertices) + " points a row";
  return copy<std::array<Vec3, Vertices>, double, 3 * Vertices>(object, name, expected);
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

// A set of collision primitives with its broad phase; the groups of edges and triangles are those of their
// vertices.
class CollisionScene {
 public:
  CollisionScene(nb::handle vertex_group, nb::handle edge_list, nb::handle triangle_list,
                 nb::handle point_list, nb::handle excluded_pairs, int threads)
      : pool_(threads) {
    SurfaceMesh mesh;
    mesh.vertex_group = numbers_of<int32_t>(vertex_group, "vertex_group", "an (n,) array of group numbers");
    mesh.vertex_count = static_cast<int32_t>(mesh.vertex_group.size());
    mesh.edges = edges(edge_list);
    mesh.triangles = triangles(triangle_list);
    mesh.points = numbers_of<int32_t>(point_list, "points", "an (n,) array of vertex indices");
    const auto group_of = [&](int32_t v) {
      return v >= 0 && v < mesh.vertex_count ? mesh.vertex_group[v] : 0;  // reset() reports bad indices
    };
    for (const Index2& e : mesh.edges) mesh.edge_group.push_back(group_of(e[0]));
    for (const Index3& t : mesh.triangles) mesh.triangle_group.push_back(group_of(t[0]));
    int32_t group_count = 0;
    for (const int32_t group : mesh.vertex_group) group_count = std::max(group_count, group + 1);
    PairFilter filter(group_count);
    for (const Index2& pair :
         copy<Index2, int32_t, 2>(excluded_pairs, "excluded_pairs", "an (n, 2) array of groups")) {
      filter.set(pair[0], pair[1], false);
    }
    broad_phase_.reset(std::move(mesh), std::move(filter));
  }

  nb::dict find(nb::handle x0, nb::handle x1, nb::handle inflation) {
    CandidateList list = candidates(positions(x0, "x0"), positions(x1, "x1"), inflation);
    nb::dict result;
    for_each_pair_kind([&](auto kind) {
      result[nb::str(PairRow<kind.value>::kName.data())] = to_numpy(std::move(list[kind]));
    });
    return result;
  }

  std::tuple<double, std::string, int, int> max_safe_step(nb::handle start, nb::handle end,
                                                          nb::handle separation) {
    const auto x0 = positions(start, "x0"), x1 = positions(end, "x1");
    const CandidateList list = candidates(x0, x1, separation);
    const auto minimum = numbers_of<double>(separation, "separation", "one number [m] for each group");
    CcdReport report;
    stark::max_safe_step(broad_phase_.mesh(), list, x0, x1, {minimum}, pool_, &report);
    return {report.step, report.kind ? std::string(to_string(*report.kind)) : "", report.first,
            report.second};
  }

  auto find_intersections(nb::handle x) {
    const auto p = positions(x, "x");
    return to_numpy(stark::find_intersections(broad_phase_.mesh(), p, broad_phase_.filter(), pool_));
  }

  auto find_contained_groups(nb::handle x) {
    const auto p = positions(x, "x");
    return to_numpy(stark::find_contained_groups(broad_phase_.mesh(), p, broad_phase_.filter(), pool_));
  }

 private:
  std::vector<Vec3> positions(nb::handle object, const char* name) {
    std::vector<Vec3> x = points(object, name);
    if (x.size() != static_cast<size_t>(broad_phase_.mesh().vertex_count)) {
      throw InvalidArgument(std::string(name) + ": got " + std::to_string(x.size()) + " rows: must be " +
                            std::to_string(broad_phase_.mesh().vertex_count) + ", one for each vertex");
    }
    return x;
  }

  CandidateList candidates(const std::vector<Vec3>& x0, const std::vector<Vec3>& x1, nb::handle inflation) {
    CandidateList list;
    broad_phase_.find_swept(
        x0, x1, numbers_of<double>(inflation, "inflation", "one number [m] for each group"), pool_, list);
    return list;
  }

  ThreadPool pool_;
  BroadPhase broad_phase_;
};

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

nb::tuple closest_triangles(nb::handle points, nb::handle vertices, nb::handle faces) {
  const auto p = points_of(points, "points", "an (n, 3) array");
  const auto x = points_of(vertices, "vertices", "an (n, 3) array");
  std::vector<int32_t> indices;
  std::vector<double> distances;
  for (const ClosestTriangle& c : find_closest_triangles(p, x, triangles(faces))) {
    indices.push_back(c.triangle);
    distances.push_back(c.distance);
  }
  return nb::make_tuple(to_numpy(std::move(indices)), to_numpy(std::move(distances)));
}

auto principal_axes(nb::handle matrix) {
  const auto a = copy<Vec3, double, 3>(matrix, "matrix", "a symmetric (3, 3) array");
  if (a.size() != 3) throw InvalidArgument("matrix: must be a symmetric (3, 3) array");
  const PrincipalAxes p = compute_principal_axes(transpose(Mat3::from_columns(a[0], a[1], a[2])));
  return std::pair(triple(p.values), nb::cast(p.axes));
}

void bind_topology(nb::module_& m) {
  const auto of_triangles = [&m](const char* name, auto function) {
    m.def(name, [function](nb::handle t) { return to_numpy(function(triangles(t))); }, "triangles"_a);
  };
  const auto of_tets = [&m](const char* name, auto function) {
    m.def(name, [function](nb::handle t) { return to_numpy(function(tets(t))); }, "tets"_a);
  };
  const auto of_mesh = [&m](const char* name, auto function) {
    m.def(
        name, [function](nb::handle x, nb::handle t) { return function(triangle_mesh(x, t)); }, "vertices"_a,
        "triangles"_a);
  };
  const auto mass_properties = [&m](const char* name, auto function, const char* argument) {
    m.def(
        name,
        [function](nb::handle x, nb::handle t, double density) {
          const TriangleMesh mesh = triangle_mesh(x, t);
          return to_dict(function(mesh.vertices, mesh.triangles, density));
        },
        "vertices"_a, "triangles"_a, nb::arg(argument));
  };
  of_triangles("find_edges", [](const auto& t) { return find_edges(t); });
  of_tets("find_tet_edges", [](const auto& t) { return find_edges(t); });
  m.def("find_closest_triangles", closest_triangles, "points"_a, "vertices"_a, "triangles"_a,
        "(triangle closest to each point, distance [m]).");
  of_triangles("find_hinges", find_hinges);
  of_triangles("find_boundary_edges", find_boundary_edges);
  of_tets("find_boundary_triangles", [](const auto& t) { return find_boundary_triangles(t); });
  of_mesh("find_connected_components", [](const TriangleMesh& mesh) {
    return to_numpy(find_connected_components(static_cast<int32_t>(mesh.vertices.size()), mesh.triangles));
  });
  m.def("is_closed", [](nb::handle t) { return is_closed(triangles(t)); }, "triangles"_a);
  m.def(
      "is_orientation_consistent", [](nb::handle t) { return is_orientation_consistent(triangles(t)); },
      "triangles"_a);
  of_mesh("compute_vertex_areas", [](const TriangleMesh& mesh) {
    return to_numpy(compute_vertex_areas(mesh.vertices, mesh.triangles));
  });
  mass_properties("compute_solid_mass_properties", compute_solid_mass_properties, "density");
  mass_properties("compute_shell_mass_properties", compute_shell_mass_properties, "area_density");
  m.def("compute_principal_axes", principal_axes, "matrix"_a);
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
  m.def(
      "locate_points",
      [](nb::handle p, nb::handle x, nb::handle t) {
        const TriangleMesh mesh = triangle_mesh(x, t);
        std::vector<uint8_t> locations;
        for (const Vec3& point : points(p, "points")) {
          locations.push_back(static_cast<uint8_t>(locate_point(point, mesh.vertices, mesh.triangles)));
        }
        return to_numpy(std::move(locations));
      },
      "points"_a, "vertices"_a, "triangles"_a, "0 outside, 1 inside, 2 on the closed surface.");
}

}  // namespace

void bind_geometry(nb::module_& m) {
  bind_shapes(m);
  bind_topology(m);
  bind_distances(m);
  nb::class_<CollisionScene>(m, "CollisionScene",
                             "Collision primitives of groups of vertices and what may touch.")
      .def(nb::init<nb::handle, nb::handle, nb::handle, nb::handle, nb::handle, int>(), "vertex_group"_a,
           "edges"_a, "triangles"_a, "points"_a = nb::tuple(), "excluded_pairs"_a = nb::tuple(),
           "threads"_a = 1)
      .def("find", &CollisionScene::find, "x0"_a, "x1"_a, "inflation"_a,
           "Candidate pairs for the linear motion x0 -> x1 with boxes inflated by each group's value [m].")
      .def("max_safe_step", &CollisionScene::max_safe_step, "x0"_a, "x1"_a, "separation"_a,
           "(step, kind, first, second): safe fraction of the motion and the pair that limits it.")
      .def("find_intersections", &CollisionScene::find_intersections, "x"_a,
           "(n, 2): edges and triangles that meet.")
      .def("find_contained_groups", &CollisionScene::find_contained_groups, "x"_a,
           "(n, 3): inner group, outer group, vertex of the inner one.");
}
