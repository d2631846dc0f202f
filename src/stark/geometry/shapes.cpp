// Meshes of simple shapes. See shapes.h.
#include <stark/geometry/shapes.h>

#include <algorithm>
#include <cmath>
#include <map>
#include <numbers>
#include <string>

#include <stark/base/error.h>
#include <stark/base/settings.h>

namespace stark {

namespace {

void check_length(double value, const char* shape, const char* parameter) {
  if (!(value > 0.0) || !std::isfinite(value)) {
    throw InvalidArgument(std::string(shape) + ": " + parameter + " is " + quantity_text(value, "m") +
                          "; it must be positive and finite");
  }
}

void check_count(int value, int least, const char* shape, const char* parameter) {
  if (value < least) {
    throw InvalidArgument(std::string(shape) + ": " + parameter + " is " + std::to_string(value) +
                          "; it must be at least " + std::to_string(least));
  }
}

// Coordinate of grid line i of n cells over `size`, exactly antisymmetric about the centre.
double grid_coordinate(double size, int i, int n) { return size * ((2.0 * i - n) / (2.0 * n)); }

// A profile (radius, z) from the bottom pole to the top pole, turned about z; first and last points are
// poles.
struct ProfilePoint {
  double radius, z;
};

void add_ring(TriangleMesh& mesh, const ProfilePoint& point, int segments) {
  for (int s = 0; s < segments; ++s) {
    const double angle = 2.0 * std::numbers::pi * s / segments;
    mesh.vertices.push_back({point.radius * std::cos(angle), point.radius * std::sin(angle), point.z});
  }
}

/// Between rings, from the vertex `first` on.
void add_bands(TriangleMesh& mesh, int32_t first, int rings, int segments) {
  const auto id = [&](int ring, int s) { return first + ring * segments + s % segments; };
  for (int ring = 0; ring + 1 < rings; ++ring) {
    for (int s = 0; s < segments; ++s) {
      mesh.triangles.push_back({id(ring, s), id(ring, s + 1), id(ring + 1, s + 1)});
      mesh.triangles.push_back({id(ring, s), id(ring + 1, s + 1), id(ring + 1, s)});
    }
  }
}

/// A polygon of a ring, from the vertex `first` on, as a strip from one side to the other.
void add_disc(TriangleMesh& mesh, int32_t first, int segments, bool faces_up) {
  int32_t low = first, high = first + segments - 1;
  for (bool is_low = true; high - low > 1; is_low = !is_low) {
    const int32_t next = is_low ? low + 1 : high - 1;
    mesh.triangles.push_back(faces_up ? Index3{low, next, high} : Index3{low, high, next});
    (is_low ? low : high) = next;
  }
}

TriangleMesh make_revolution(const std::vector<ProfilePoint>& profile, int segments) {
  TriangleMesh mesh;
  const int rings = static_cast<int>(profile.size()) - 2;
  mesh.vertices.push_back({0.0, 0.0, profile.front().z});
  for (int ring = 0; ring < rings; ++ring) add_ring(mesh, profile[ring + 1], segments);
  mesh.vertices.push_back({0.0, 0.0, profile.back().z});
  const int32_t top = static_cast<int32_t>(mesh.vertices.size()) - 1, last = top - segments;
  for (int s = 0; s < segments; ++s) mesh.triangles.push_back({0, 1 + (s + 1) % segments, 1 + s});
  add_bands(mesh, 1, rings, segments);
  for (int s = 0; s < segments; ++s) mesh.triangles.push_back({last + s, last + (s + 1) % segments, top});
  return mesh;
}

}  // namespace

TriangleMesh make_grid(double size_x, double size_y, int cells_x, int cells_y) {
  check_length(size_x, "grid", "size_x");
  check_length(size_y, "grid", "size_y");
  check_count(cells_x, 1, "grid", "cells_x");
  check_count(cells_y, 1, "grid", "cells_y");
  TriangleMesh mesh;
  for (int j = 0; j <= cells_y; ++j) {
    for (int i = 0; i <= cells_x; ++i) {
      mesh.vertices.push_back(
          {grid_coordinate(size_x, i, cells_x), grid_coordinate(size_y, j, cells_y), 0.0});
    }
  }
  const auto id = [&](int i, int j) { return static_cast<int32_t>(j * (cells_x + 1) + i); };
  for (int j = 0; j < cells_y; ++j) {
    for (int i = 0; i < cells_x; ++i) {
      mesh.triangles.push_back({id(i, j), id(i + 1, j), id(i + 1, j + 1)});
      mesh.triangles.push_back({id(i, j), id(i + 1, j + 1), id(i, j + 1)});
    }
  }
  return mesh;
}

TriangleMesh make_box(const Vec3& size, int subdivisions) {
  check_length(size.x, "box", "size x");
  check_length(size.y, "box", "size y");
  check_length(size.z, "box", "size z");
  check_count(subdivisions, 1, "box", "subdivisions");
  const int n = subdivisions;
  TriangleMesh mesh;
  std::map<Index3, int32_t> ids;  // lattice coordinates -> vertex
  const auto id = [&](const Index3& ijk) {
    const auto [position, is_new] = ids.try_emplace(ijk, static_cast<int32_t>(mesh.vertices.size()));
    if (is_new) {
      mesh.vertices.push_back({grid_coordinate(size.x, ijk[0], n), grid_coordinate(size.y, ijk[1], n),
                               grid_coordinate(size.z, ijk[2], n)});
    }
    return position->second;
  };
  for (int axis = 0; axis < 3; ++axis) {
    const int u = (axis + 1) % 3, v = (axis + 2) % 3;
    for (int side = 0; side < 2; ++side) {
      for (int j = 0; j < n; ++j) {
        for (int i = 0; i < n; ++i) {
          const auto corner = [&](int du, int dv) {
            Index3 ijk{};
            ijk[axis] = side * n;
            ijk[u] = i + du;
            ijk[v] = j + dv;
            return id(ijk);
          };
          const int32_t c00 = corner(0, 0), c10 = corner(1, 0), c11 = corner(1, 1), c01 = corner(0, 1);
          if (side == 1) {
            mesh.triangles.push_back({c00, c10, c11});
            mesh.triangles.push_back({c00, c11, c01});
          } else {
            mesh.triangles.push_back({c00, c11, c10});
            mesh.triangles.push_back({c00, c01, c11});
          }
        }
      }
    }
  }
  return mesh;
}

TriangleMesh make_icosphere(double radius, int subdivisions) {
  check_length(radius, "icosphere", "radius");
  check_count(subdivisions, 0, "icosphere", "subdivisions");
  const double phi = std::numbers::phi;
  TriangleMesh mesh;
  mesh.vertices = {{-1, phi, 0},  {1, phi, 0},  {-1, -phi, 0}, {1, -phi, 0}, {0, -1, phi},  {0, 1, phi},
                   {0, -1, -phi}, {0, 1, -phi}, {phi, 0, -1},  {phi, 0, 1},  {-phi, 0, -1}, {-phi, 0, 1}};
  mesh.triangles = {{0, 11, 5},  {0, 5, 1},  {0, 1, 7},  {0, 7, 10}, {0, 10, 11}, {1, 5, 9}, {5, 11, 4},
                    {11, 10, 2}, {10, 7, 6}, {7, 1, 8},  {3, 9, 4},  {3, 4, 2},   {3, 2, 6}, {3, 6, 8},
                    {3, 8, 9},   {4, 9, 5},  {2, 4, 11}, {6, 2, 10}, {8, 6, 7},   {9, 8, 1}};
  for (Vec3& vertex : mesh.vertices) vertex = normalized(vertex);
  for (int level = 0; level < subdivisions; ++level) {
    std::map<Index2, int32_t> midpoints;
    const auto midpoint = [&](int32_t a, int32_t b) {
      const Index2 key{std::min(a, b), std::max(a, b)};
      const auto [position, is_new] = midpoints.try_emplace(key, static_cast<int32_t>(mesh.vertices.size()));
      if (is_new) mesh.vertices.push_back(normalized(mesh.vertices[key[0]] + mesh.vertices[key[1]]));
      return position->second;
    };
    std::vector<Index3> triangles;
    triangles.reserve(4 * mesh.triangles.size());
    for (const Index3& t : mesh.triangles) {
      const int32_t a = midpoint(t[0], t[1]), b = midpoint(t[1], t[2]), c = midpoint(t[2], t[0]);
      triangles.push_back({t[0], a, c});
      triangles.push_back({a, t[1], b});
      triangles.push_back({c, b, t[2]});
      triangles.push_back({a, b, c});
    }
    mesh.triangles = std::move(triangles);
  }
  for (Vec3& vertex : mesh.vertices) vertex *= radius;
  return mesh;
}

TriangleMesh make_cylinder(double radius, double height, int segments, int stacks) {
  check_length(radius, "cylinder", "radius");
  check_length(height, "cylinder", "height");
  check_count(segments, 3, "cylinder", "segments");
  check_count(stacks, 1, "cylinder", "stacks");
  // No vertices in the middle of the ends: friction knows how an even pressure spreads over a flat face that
  // has none inside. [theory eq. 19d]
  TriangleMesh mesh;
  for (int k = 0; k <= stacks; ++k) add_ring(mesh, {radius, grid_coordinate(height, k, stacks)}, segments);
  add_disc(mesh, 0, segments, false);
  add_bands(mesh, 0, stacks + 1, segments);
  add_disc(mesh, stacks * segments, segments, true);
  return mesh;
}

TriangleMesh make_capsule(double radius, double height, int segments, int rings) {
  check_length(radius, "capsule", "radius");
  check_length(height, "capsule", "height");
  check_count(segments, 3, "capsule", "segments");
  check_count(rings, 1, "capsule", "rings");
  std::vector<ProfilePoint> profile = {{0.0, -0.5 * height - radius}};
  for (int half = 0; half < 2; ++half) {
    for (int k = 0; k < rings; ++k) {
      // The lower half runs from below the equator up to it, the upper half from the equator.
      const double latitude =
          0.5 * std::numbers::pi * (half == 0 ? (k + 1.0) / rings - 1.0 : double(k) / rings);
      profile.push_back({radius * std::cos(latitude), (half - 0.5) * height + radius * std::sin(latitude)});
    }
  }
  profile.push_back({0.0, 0.5 * height + radius});
  return make_revolution(profile, segments);
}

TriangleMesh make_torus(double major_radius, double minor_radius, int major_segments, int minor_segments) {
  check_length(major_radius, "torus", "major_radius");
  check_length(minor_radius, "torus", "minor_radius");
  check_count(major_segments, 3, "torus", "major_segments");
  check_count(minor_segments, 3, "torus", "minor_segments");
  if (minor_radius >= major_radius) {
    throw InvalidArgument("torus: minor_radius is " + quantity_text(minor_radius, "m") +
                          "; it must be less than major_radius, " + quantity_text(major_radius, "m"));
  }
  TriangleMesh mesh;
  for (int i = 0; i < major_segments; ++i) {
    const double u = 2.0 * std::numbers::pi * i / major_segments;
    for (int j = 0; j < minor_segments; ++j) {
      const double v = 2.0 * std::numbers::pi * j / minor_segments;
      const double r = major_radius + minor_radius * std::cos(v);
      mesh.vertices.push_back({r * std::cos(u), r * std::sin(u), minor_radius * std::sin(v)});
    }
  }
  const auto id = [&](int i, int j) {
    return static_cast<int32_t>((i % major_segments) * minor_segments + j % minor_segments);
  };
  for (int i = 0; i < major_segments; ++i) {
    for (int j = 0; j < minor_segments; ++j) {
      mesh.triangles.push_back({id(i, j), id(i + 1, j), id(i + 1, j + 1)});
      mesh.triangles.push_back({id(i, j), id(i + 1, j + 1), id(i, j + 1)});
    }
  }
  return mesh;
}

TetMesh make_tet_box(const Vec3& size, const Index3& cells) {
  check_length(size.x, "tet box", "size x");
  check_length(size.y, "tet box", "size y");
  check_length(size.z, "tet box", "size z");
  for (const int32_t count : cells) check_count(count, 1, "tet box", "cell count");
  TetMesh mesh;
  const int nx = cells[0], ny = cells[1], nz = cells[2];
  const auto corner_id = [&](int i, int j, int k) {
    return static_cast<int32_t>((k * (ny + 1) + j) * (nx + 1) + i);
  };
  for (int k = 0; k <= nz; ++k) {
    for (int j = 0; j <= ny; ++j) {
      for (int i = 0; i <= nx; ++i) {
        mesh.vertices.push_back(
            {grid_coordinate(size.x, i, nx), grid_coordinate(size.y, j, ny), grid_coordinate(size.z, k, nz)});
      }
    }
  }
  // Half steps of the doubled grid are the centres of the cells.
  for (int k = 0; k < nz; ++k) {
    for (int j = 0; j < ny; ++j) {
      for (int i = 0; i < nx; ++i) {
        const int32_t centre = static_cast<int32_t>(mesh.vertices.size());
        mesh.vertices.push_back({grid_coordinate(size.x, 2 * i + 1, 2 * nx),
                                 grid_coordinate(size.y, 2 * j + 1, 2 * ny),
                                 grid_coordinate(size.z, 2 * k + 1, 2 * nz)});
        for (int axis = 0; axis < 3; ++axis) {
          const int u = (axis + 1) % 3, v = (axis + 2) % 3;
          for (int side = 0; side < 2; ++side) {
            const auto corner = [&](int du, int dv) {
              int d[3];
              d[axis] = side;
              d[u] = du;
              d[v] = dv;
              return corner_id(i + d[0], j + d[1], k + d[2]);
            };
            // The diagonal joins corners of even parity in global lattice coordinates, so that neighbouring
            // cells agree on the shared face.
            const int parity = (i + j + k + side) & 1;
            const int32_t c[4] = {corner(0, 0), corner(1, 0), corner(1, 1), corner(0, 1)};
            const Index3 faces[2] = {{c[parity], c[parity + 1], c[(parity + 2) % 4]},
                                     {c[parity], c[(parity + 2) % 4], c[(parity + 3) % 4]}};
            for (const Index3& f : faces) {
              // Seen from the centre the outward face is the base of a positively oriented tet with the
              // centre first.
              if (side == 1) {
                mesh.tets.push_back({centre, f[0], f[1], f[2]});
              } else {
                mesh.tets.push_back({centre, f[0], f[2], f[1]});
              }
            }
          }
        }
      }
    }
  }
  return mesh;
}

}  // namespace stark
