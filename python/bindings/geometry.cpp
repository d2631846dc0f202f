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

#include "arrays.h"

namespace nb = nanobind;
using namespace nb::literals;
using namespace stark;
using bindings::array;
using bindings::Column;
using bindings::rows;
using bindings::Rows;
using bindings::to_numpy;
using bindings::values;

namespace {

using Triple = std::array<double, 3>;
using Doubles = nb::ndarray<nb::numpy, double>;
using Ints = nb::ndarray<nb::numpy, int32_t>;

Vec3 vec(const Triple& a) { return {a[0], a[1], a[2]}; }

template <typename Value, typename T, long Columns>
std::vector<Value> copy(nb::handle object, const char* name, const std::string& expected) {
  if (nb::hasattr(object, "__len__") && nb::len(object) == 0) return {};  // [] has no columns
  const auto source = array<Rows<T, Columns>>(object, name, expected);
  const auto span = rows<Value>(source);
  return {span.begin(), span.end()};
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
template <typename T>
std::vector<T> numbers(nb::handle object, const char* name, const char* expected) {
  const auto source = array<Column<T>>(object, name, expected);
  return {values(source).begin(), values(source).end()};
}

TriangleMesh triangle_mesh(nb::handle vertices, nb::handle faces) {
  TriangleMesh mesh{points(vertices, "vertices"), triangles(faces)};
  validate(mesh, "mesh");
  return mesh;
}

std::pair<Doubles, Ints> to_arrays(TriangleMesh mesh) {
  return {to_numpy<double>(std::move(mesh.vertices)), to_numpy<int32_t>(std::move(mesh.triangles))};
}
std::pair<Doubles, Ints> to_arrays(TetMesh mesh) {
  return {to_numpy<double>(std::move(mesh.vertices)), to_numpy<int32_t>(std::move(mesh.tets))};
}
nb::object to_array(const Mat3& m) {
  const nb::object flat = nb::cast(to_numpy<double>(std::vector<double>(m.m.begin(), m.m.end())));
  return flat.attr("reshape")(3, 3);
}

nb::dict to_dict(const MassProperties& p) {
  nb::dict result;
  result["measure"] = p.measure;
  result["mass"] = p.mass;
  result["centre"] = Triple{p.centre.x, p.centre.y, p.centre.z};
  result["inertia"] = to_array(p.inertia);
  return result;
}

// (n, 3 Vertices) array: n stencils of so many vertices each.
template <size_t Vertices>
std::vector<std::array<Vec3, Vertices>> stencils(nb::handle object, const char* name) {
  const std::string expected = "an (n, " + std::to_string(3 * Vertices) +
                               ") array of numbers [m]: " + std::to_string(Vertices) + " points a row";
  return copy<std::array<Vec3, Vertices>, double, 3 * Vertices>(object, name, expected);
}

// Types, squared distances and weights of the vertices of the second (or both) primitives for each row.
template <size_t Vertices, typename Type, size_t Weights>
std::tuple<nb::ndarray<nb::numpy, uint8_t>, Doubles, Doubles> classify(
    nb::handle object, Type (*type_of)(const std::array<Vec3, Vertices>&),
    double (*distance_of)(const std::array<Vec3, Vertices>&, Type),
    std::array<double, Weights> (*weights_of)(const std::array<Vec3, Vertices>&, Type)) {
  const auto x = stencils<Vertices>(object, "stencils");
  std::vector<uint8_t> types(x.size());
  std::vector<double> distances(x.size());
  std::vector<std::array<double, Weights>> weights(x.size());
  for (size_t k = 0; k < x.size(); ++k) {
    const Type type = type_of(x[k]);
    types[k] = static_cast<uint8_t>(type);
    distances[k] = distance_of(x[k], type);
    weights[k] = weights_of(x[k], type);
  }
  return {to_numpy<uint8_t>(std::move(types)), to_numpy<double>(std::move(distances)),
          to_numpy<double>(std::move(weights))};
}

template <size_t Vertices>
Doubles ccd(nb::handle start, nb::handle end, double min_separation, double time_margin,
            double (*function)(const std::array<Vec3, Vertices>&, const std::array<Vec3, Vertices>&, double,
                               const CcdSettings&)) {
  const auto x0 = stencils<Vertices>(start, "x0"), x1 = stencils<Vertices>(end, "x1");
  if (x0.size() != x1.size()) throw InvalidArgument("x0 and x1 have different numbers of rows");
  CcdSettings settings;
  settings.time_margin = time_margin;
  std::vector<double> steps(x0.size());
  for (size_t k = 0; k < x0.size(); ++k) steps[k] = function(x0[k], x1[k], min_separation, settings);
  return to_numpy<double>(std::move(steps));
}

template <size_t Vertices>
void def_ccd(nb::module_& m, const char* name,
             double (*function)(const std::array<Vec3, Vertices>&, const std::array<Vec3, Vertices>&, double,
                                const CcdSettings&)) {
  m.def(
      name,
      [function](nb::handle x0, nb::handle x1, double min_separation, double time_margin) {
        return ccd<Vertices>(x0, x1, min_separation, time_margin, function);
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
    mesh.vertex_group = numbers<int32_t>(vertex_group, "vertex_group", "an (n,) array of group numbers");
    mesh.vertex_count = static_cast<int32_t>(mesh.vertex_group.size());
    mesh.edges = edges(edge_list);
    mesh.triangles = triangles(triangle_list);
    mesh.points = numbers<int32_t>(point_list, "points", "an (n,) array of vertex indices");
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
      result[nb::str(PairRow<kind.value>::kName.data())] = to_numpy<int32_t>(std::move(list[kind]));
    });
    return result;
  }

  std::tuple<double, std::string, int, int> max_safe_step(nb::handle start, nb::handle end,
                                                          nb::handle separation) {
    const auto x0 = positions(start, "x0"), x1 = positions(end, "x1");
    const CandidateList list = candidates(x0, x1, separation);
    const auto minimum = numbers<double>(separation, "separation", "one number [m] for each group");
    CcdReport report;
    stark::max_safe_step(broad_phase_.mesh(), list, x0, x1, {minimum}, pool_, &report);
    return {report.step, report.kind ? std::string(to_string(*report.kind)) : "", report.first,
            report.second};
  }

  Ints find_intersections(nb::handle x) {
    const auto p = positions(x, "x");
    return to_numpy<int32_t>(stark::find_intersections(broad_phase_.mesh(), p, broad_phase_.filter(), pool_));
  }

  Ints find_contained_groups(nb::handle x) {
    const auto p = positions(x, "x");
    return to_numpy<int32_t>(
        stark::find_contained_groups(broad_phase_.mesh(), p, broad_phase_.filter(), pool_));
  }

 private:
  std::vector<Vec3> positions(nb::handle object, const char* name) {
    std::vector<Vec3> x = points(object, name);
    if (x.size() != static_cast<size_t>(broad_phase_.mesh().vertex_count)) {
      throw InvalidArgument(std::string(name) + ": got " + std::to_string(x.size()) + " rows, need " +
                            std::to_string(broad_phase_.mesh().vertex_count) + ", one for each vertex");
    }
    return x;
  }

  CandidateList candidates(const std::vector<Vec3>& x0, const std::vector<Vec3>& x1, nb::handle inflation) {
    CandidateList list;
    broad_phase_.find_swept(x0, x1, numbers<double>(inflation, "inflation", "one number [m] for each group"),
                            pool_, list);
    return list;
  }

  ThreadPool pool_;
  BroadPhase broad_phase_;
};

void bind_shapes(nb::module_& m) {
  m.def(
      "make_grid", [](double x, double y, int nx, int ny) { return to_arrays(make_grid(x, y, nx, ny)); },
      "size_x"_a, "size_y"_a, "cells_x"_a, "cells_y"_a);
  m.def(
      "make_box", [](const Triple& size, int n) { return to_arrays(make_box(vec(size), n)); }, "size"_a,
      "subdivisions"_a = 1);
  m.def(
      "make_icosphere", [](double r, int n) { return to_arrays(make_icosphere(r, n)); }, "radius"_a,
      "subdivisions"_a);
  m.def(
      "make_cylinder", [](double r, double h, int n, int k) { return to_arrays(make_cylinder(r, h, n, k)); },
      "radius"_a, "height"_a, "segments"_a = 32, "stacks"_a = 1);
  m.def(
      "make_capsule", [](double r, double h, int n, int k) { return to_arrays(make_capsule(r, h, n, k)); },
      "radius"_a, "height"_a, "segments"_a = 32, "rings"_a = 8);
  m.def(
      "make_torus", [](double a, double b, int n, int k) { return to_arrays(make_torus(a, b, n, k)); },
      "major_radius"_a, "minor_radius"_a, "major_segments"_a = 48, "minor_segments"_a = 24);
  m.def(
      "make_tet_box",
      [](const Triple& size, const Index3& n) { return to_arrays(make_tet_box(vec(size), n)); }, "size"_a,
      "cells"_a);
}

void bind_topology(nb::module_& m) {
  m.def(
      "find_edges", [](nb::handle t) { return to_numpy<int32_t>(find_edges(triangles(t))); }, "triangles"_a);
  m.def("find_tet_edges", [](nb::handle t) { return to_numpy<int32_t>(find_edges(tets(t))); }, "tets"_a);
  m.def(
      "find_closest_triangles",
      [](nb::handle points, nb::handle vertices, nb::handle t) {
        const auto p = array<Rows<double, 3>>(points, "points", "an (n, 3) array");
        const auto x = array<Rows<double, 3>>(vertices, "vertices", "an (n, 3) array");
        std::vector<int32_t> indices;
        std::vector<double> distances;
        for (const ClosestTriangle& c : find_closest_triangles(rows<Vec3>(p), rows<Vec3>(x), triangles(t))) {
          indices.push_back(c.triangle);
          distances.push_back(c.distance);
        }
        return nb::make_tuple(to_numpy<int32_t>(std::move(indices)), to_numpy<double>(std::move(distances)));
      },
      "points"_a, "vertices"_a, "triangles"_a, "(triangle closest to each point, distance [m]).");
  m.def(
      "find_hinges", [](nb::handle t) { return to_numpy<int32_t>(find_hinges(triangles(t))); },
      "triangles"_a);
  m.def(
      "find_boundary_edges",
      [](nb::handle t) { return to_numpy<int32_t>(find_boundary_edges(triangles(t))); }, "triangles"_a);
  m.def(
      "find_boundary_triangles",
      [](nb::handle t) { return to_numpy<int32_t>(find_boundary_triangles(tets(t))); }, "tets"_a);
  m.def(
      "find_connected_components",
      [](nb::handle x, nb::handle t) {
        const TriangleMesh mesh = triangle_mesh(x, t);
        return to_numpy<int32_t>(
            find_connected_components(static_cast<int32_t>(mesh.vertices.size()), mesh.triangles));
      },
      "vertices"_a, "triangles"_a);
  m.def("is_closed", [](nb::handle t) { return is_closed(triangles(t)); }, "triangles"_a);
  m.def(
      "is_orientation_consistent", [](nb::handle t) { return is_orientation_consistent(triangles(t)); },
      "triangles"_a);
  m.def(
      "compute_vertex_areas",
      [](nb::handle x, nb::handle t) {
        const TriangleMesh mesh = triangle_mesh(x, t);
        return to_numpy<double>(compute_vertex_areas(mesh.vertices, mesh.triangles));
      },
      "vertices"_a, "triangles"_a);
  m.def(
      "compute_solid_mass_properties",
      [](nb::handle x, nb::handle t, double density) {
        const TriangleMesh mesh = triangle_mesh(x, t);
        return to_dict(compute_solid_mass_properties(mesh.vertices, mesh.triangles, density));
      },
      "vertices"_a, "triangles"_a, "density"_a);
  m.def(
      "compute_shell_mass_properties",
      [](nb::handle x, nb::handle t, double density) {
        const TriangleMesh mesh = triangle_mesh(x, t);
        return to_dict(compute_shell_mass_properties(mesh.vertices, mesh.triangles, density));
      },
      "vertices"_a, "triangles"_a, "area_density"_a);
  m.def(
      "compute_principal_axes",
      [](nb::handle matrix) {
        const auto a = copy<Vec3, double, 3>(matrix, "matrix", "a symmetric (3, 3) array");
        if (a.size() != 3) throw InvalidArgument("matrix: need a symmetric (3, 3) array");
        const PrincipalAxes p = compute_principal_axes(transpose(Mat3::from_columns(a[0], a[1], a[2])));
        return std::pair(Triple{p.values.x, p.values.y, p.values.z}, to_array(p.axes));
      },
      "matrix"_a);
}

void bind_distances(nb::module_& m) {
  using S3 = std::array<Vec3, 3>;
  using S4 = std::array<Vec3, 4>;
  constexpr const char* kDoc =
      "Closest features (type numbers), squared distances and weights, one stencil a row.";
  m.def(
      "classify_point_edge",
      [](nb::handle x) {
        return classify<3, PointEdgeType, 2>(
            x, [](const S3& s) { return point_edge_type(s[0], s[1], s[2]); },
            [](const S3& s, PointEdgeType t) { return point_edge_squared_distance(s[0], s[1], s[2], t); },
            [](const S3& s, PointEdgeType t) { return point_edge_weights(s[0], s[1], s[2], t); });
      },
      "stencils"_a, kDoc);
  m.def(
      "classify_point_triangle",
      [](nb::handle x) {
        return classify<4, PointTriangleType, 3>(
            x, [](const S4& s) { return point_triangle_type(s[0], s[1], s[2], s[3]); },
            [](const S4& s, PointTriangleType t) {
              return point_triangle_squared_distance(s[0], s[1], s[2], s[3], t);
            },
            [](const S4& s, PointTriangleType t) {
              return point_triangle_weights(s[0], s[1], s[2], s[3], t);
            });
      },
      "stencils"_a, kDoc);
  m.def(
      "classify_edge_edge",
      [](nb::handle x) {
        return classify<4, EdgeEdgeType, 4>(
            x, [](const S4& s) { return edge_edge_type(s[0], s[1], s[2], s[3]); },
            [](const S4& s, EdgeEdgeType t) { return edge_edge_squared_distance(s[0], s[1], s[2], s[3], t); },
            [](const S4& s, EdgeEdgeType t) { return edge_edge_weights(s[0], s[1], s[2], s[3], t); });
      },
      "stencils"_a, kDoc);
  def_ccd<2>(m, "point_point_ccd", point_point_ccd);
  def_ccd<3>(m, "point_edge_ccd", point_edge_ccd);
  def_ccd<4>(m, "point_triangle_ccd", point_triangle_ccd);
  def_ccd<4>(m, "edge_edge_ccd", edge_edge_ccd);
  m.def(
      "orient3d",
      [](const Triple& a, const Triple& b, const Triple& c, const Triple& d) {
        return orient3d(vec(a), vec(b), vec(c), vec(d));
      },
      "a"_a, "b"_a, "c"_a, "d"_a);
  m.def(
      "segment_intersects_triangle",
      [](nb::handle stencil_rows) {
        std::vector<uint8_t> hits;
        for (const auto& s : stencils<5>(stencil_rows, "stencils")) {
          hits.push_back(segment_intersects_triangle(s[0], s[1], s[2], s[3], s[4]));
        }
        return to_numpy<uint8_t>(std::move(hits));
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
        return to_numpy<uint8_t>(std::move(locations));
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
