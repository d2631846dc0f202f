// Kinds of bodies and what the rest of sim asks of them: a row each, which body_kinds.inc lists and
// kinds/<name>.cpp fills, so that nothing else has to tell kinds apart. Phase: scene description.
#pragma once

#include <array>
#include <cstdint>
#include <limits>
#include <span>
#include <string_view>
#include <vector>

#include <stark/base/settings.h>
#include <stark/geometry/mesh.h>
#include <stark/sim/scene/ids.h>

namespace stark {

class Scene;

enum class BodyKind : uint8_t {
#define STARK_BODY_KIND(Kind, name) Kind,
#include <stark/sim/scene/body_kinds.inc>
};

template <>
struct EnumNames<BodyKind> {
  static constexpr std::array kNames{
#define STARK_BODY_KIND(Kind, name) std::string_view(#name),
#include <stark/sim/scene/body_kinds.inc>
  };
};

/// What of the state a body's vertices follow.
enum class MovedBy : uint8_t {
  Points,     ///< each has a position of its own
  RigidBody,  ///< all have one pose
  Nodes,      ///< each has a position and a frame
};

/// Elements of a body as lists of vertices, and which of those an edge joins.
struct BodyElements {
  std::vector<int32_t> vertices{};  ///< [count][width]
  size_t width = 0;
  std::vector<Index2> edges{};  ///< within an element
  size_t count() const { return width == 0 ? 0 : vertices.size() / width; }
  std::span<const int32_t> at(size_t e) const { return {vertices.data() + e * width, width}; }
};

/// What is told of a material where numbers may be in other units than SI.
struct MaterialScale {
  double density = 0.0;                                             ///< of its first element
  bool is_area_density = false;                                     ///< [kg/m^2], else [kg/m^3]
  double youngs_modulus = std::numeric_limits<double>::infinity();  ///< [Pa] the smallest; infinity: unknown
  double thickness = 0.0;                                           ///< [m] of sheets
  double rigidity_ratio = 0.0;  ///< flexural rigidity over that of a homogeneous sheet; 0: unknown
  double strain_limit = std::numeric_limits<double>::infinity();  ///< of its first element; infinity: none
};

struct BodyKindRow {
  std::string_view title;  ///< in messages: "rigid body"
  MovedBy moved_by = MovedBy::Points;
  bool is_thin = false;  ///< a sheet or a line, which has two sides and no inside
  bool can_be_filled = false;
  std::span<const std::string_view> rest_fields{};  ///< of mechanics/rest_state.h
  /// Mass of each vertex [kg]; null where vertices have none of their own.
  std::vector<double> (*vertex_masses)(const Scene&, BodyId) = nullptr;
  double (*mass)(const Scene&, BodyId) = nullptr;  ///< [kg] without layers; null: that of the vertices
  /// Triangles that touch others; null: the edges of the elements do.
  std::vector<Index3> (*surface)(const Scene&, BodyId) = nullptr;
  BodyElements (*elements)(const Scene&, BodyId) = nullptr;         ///< what strains; null: nothing does
  MaterialScale (*material_scale)(const Scene&, BodyId) = nullptr;  ///< null: no material
};

#define STARK_BODY_KIND(Kind, name) extern const BodyKindRow k##Kind##Row;
#include <stark/sim/scene/body_kinds.inc>

const BodyKindRow& row_of(BodyKind kind);
BodyElements elements_of(const Scene& scene, BodyId body);  ///< none of what does not strain
/// Edges of all elements in order, again where elements share one.
std::vector<Index2> edges_of(const Scene& scene, BodyId body);
inline bool has_points(BodyKind kind) { return row_of(kind).moved_by == MovedBy::Points; }
inline bool has_nodes(BodyKind kind) { return row_of(kind).moved_by == MovedBy::Nodes; }
inline bool is_rigid(BodyKind kind) { return row_of(kind).moved_by == MovedBy::RigidBody; }

}  // namespace stark
