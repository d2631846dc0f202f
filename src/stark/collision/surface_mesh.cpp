// Checks of collision primitives. See surface_mesh.h.
#include <stark/collision/surface_mesh.h>

#include <string>

#include <stark/base/error.h>

namespace stark {

namespace {

[[noreturn]] void throw_mesh(const std::string& what) { throw InvalidMesh("collision mesh: " + what); }

template <size_t N>
void check_primitives(const std::vector<std::array<int32_t, N>>& primitives,
                      const std::vector<int32_t>& groups, const SurfaceMesh& mesh, const char* kind) {
  if (groups.size() != primitives.size()) {
    throw_mesh(std::to_string(primitives.size()) + " " + kind + "s, but " + std::to_string(groups.size()) +
               " groups of them; give one group each");
  }
  for (size_t k = 0; k < primitives.size(); ++k) {
    for (const int32_t v : primitives[k]) {
      if (v < 0 || v >= mesh.vertex_count) {
        throw_mesh(std::string(kind) + " " + std::to_string(k) + " uses vertex " + std::to_string(v) +
                   ", but there are " + std::to_string(mesh.vertex_count) + " vertices (0-based)");
      }
      if (mesh.vertex_group[v] != groups[k]) {
        throw_mesh(std::string(kind) + " " + std::to_string(k) + " of group " + std::to_string(groups[k]) +
                   " uses vertex " + std::to_string(v) + " of group " + std::to_string(mesh.vertex_group[v]) +
                   "; a primitive and its vertices must be of one group");
      }
    }
    for (size_t i = 0; i < N; ++i) {
      if (primitives[k][i] == primitives[k][(i + 1) % N]) {
        throw_mesh(std::string(kind) + " " + std::to_string(k) + " uses vertex " +
                   std::to_string(primitives[k][i]) + " twice; remove the degenerate primitive");
      }
    }
  }
}

}  // namespace

void validate(const SurfaceMesh& mesh, int32_t group_count) {
  if (mesh.vertex_group.size() != static_cast<size_t>(mesh.vertex_count)) {
    throw_mesh(std::to_string(mesh.vertex_count) + " vertices, but " +
               std::to_string(mesh.vertex_group.size()) + " groups of vertices; give one group each");
  }
  const auto check_group = [&](int32_t group) {
    if (group < 0 || group >= group_count) {
      throw_mesh("group " + std::to_string(group) + " is not in [0, " + std::to_string(group_count) +
                 "), the range of the pair filter");
    }
  };
  check_primitives(mesh.edges, mesh.edge_group, mesh, "edge");
  check_primitives(mesh.triangles, mesh.triangle_group, mesh, "triangle");
  for (const int32_t group : mesh.edge_group) check_group(group);
  for (const int32_t group : mesh.triangle_group) check_group(group);
  for (const int32_t v : mesh.points) {
    if (v < 0 || v >= mesh.vertex_count) {
      throw_mesh("point " + std::to_string(v) + " is not one of the " + std::to_string(mesh.vertex_count) +
                 " vertices (0-based)");
    }
    check_group(mesh.vertex_group[v]);
  }
}

}  // namespace stark
