// Checks of what users hand to a Scene: meshes, poses, numbers. Every failure throws with the name of the
// object, the value with its unit, the rule and a remedy; what can be simulated but is suspicious is appended
// to `warnings`.
#pragma once

#include <span>
#include <string>
#include <string_view>
#include <vector>

#include <stark/base/math.h>
#include <stark/base/settings.h>
#include <stark/geometry/mesh.h>
#include <stark/geometry/solid_mesh.h>
#include <stark/sim/scene/materials.h>

namespace stark {

/// Throws InvalidArgument: "owner: name = -1 kg: must be > 0; remedy".
void check_number(std::string_view owner, std::string_view name, double value, std::string_view unit,
                  const FieldRule& rule, std::string_view remedy);
void check_finite(std::string_view owner, std::string_view name, const Vec3& value, std::string_view unit);
/// A proper rotation: orthonormal to 1e-6 with determinant +1.
void check_rotation(std::string_view owner, const Mat3& rotation);

/// Surface of a rigid body: not empty, finite, indices in range, no repeated vertex or zero area in a
/// triangle.
void check_rigid_mesh(std::string_view owner, const TriangleMesh& mesh, std::vector<std::string>& warnings);
/// As above; also every vertex used (it would have no mass) and no triangle too thin to compute with.
void check_cloth_mesh(std::string_view owner, const TriangleMesh& mesh, std::vector<std::string>& warnings);
/// Elements with positive Jacobians at all quadrature points, not too flat, every vertex used.
void check_solid_mesh(std::string_view owner, const SolidMesh& mesh);

/// Triangles on the vertices of a mesh: as above; none twice, not all vertices need to be used.
void check_layer_triangles(std::string_view owner, const TriangleMesh& mesh,
                           std::vector<std::string>& warnings);

/// Warns of a plate on diagonals in turn, which bends too easily there. [theory section 4]
void warn_about_weak_plates(std::string_view owner, const TriangleMesh& mesh, const ShellMaterial& material,
                            std::vector<std::string>& warnings);

/// Warns of a limit on the stretch of edges where edges leave a direction free on more than a tenth of the
/// area of a sheet.
void warn_about_free_directions(std::string_view owner, const TriangleMesh& mesh,
                                const ShellMaterial& material, std::vector<std::string>& warnings);

/// At least two finite points, no edge much shorter than the longest one, no bend too sharp for frames along
/// it. `what` says which polyline it is.
void check_polyline(const std::string& owner, const std::string& what, std::span<const Vec3> points);
void check_edge_lengths(const std::string& owner, const std::string& what, std::span<const Vec3> points);
/// First axis of the sections along a polyline: finite, with a part across the first edge.
void check_normal(const std::string& owner, const Vec3& normal, std::span<const Vec3> points);

/// As many finite positions as the rest mesh has vertices.
void check_initial_positions(std::string_view owner, std::span<const Vec3> positions, size_t vertex_count);

/// The surface encloses a volume: closed, consistently oriented, outwards. Throws InvalidMesh with the first
/// open edge.
void check_closed(std::string_view owner, const TriangleMesh& mesh, std::string_view purpose);

/// Smallest height of the triangles [m] and which triangle has it.
struct SmallestHeight {
  double height = 0.0;
  int32_t triangle = -1;
};
SmallestHeight find_smallest_height(std::span<const Vec3> vertices, std::span<const Index3> triangles);

}  // namespace stark
