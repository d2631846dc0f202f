// Descriptions of what is added to scenes, from dictionaries of the Python front end: their fields
// (sim/description_fields.h) by name, and what those are made of.
#pragma once

#include <utility>

#include <stark/sim/scene.h>

#include "given.h"

namespace stark::bindings {

/// "node_point" and "node_direction" are points and directions with a `node`.
template <>
PointKind read(nb::handle kind, const std::string& name, const std::string& expected);
template <>
PointSet read(nb::handle entries, const std::string& name, const std::string& expected);
/// Of a node, which has an entry of that name instead of vertices, too.
template <>
FrameDescription read(nb::handle entries, const std::string& name, const std::string& expected);
/// (joint, name)
template <>
CoordinateName read(nb::handle pair, const std::string& name, const std::string& expected);
/// (mass, centre of mass, tensor)
template <>
RigidInertia read(nb::handle parts, const std::string& name, const std::string& expected);

// Entries of a description beside its fields.
inline void read_rest(const Given&, const auto&) {}
/// "vertices" and "triangles" of the mesh
template <typename Body>
  requires requires(Body body) { body.mesh; }
void read_rest(const Given& given, Body& body) {
  given.read("vertices", body.mesh.vertices);
  if constexpr (requires { body.mesh.triangles; }) given.read("triangles", body.mesh.triangles);
}
void read_rest(const Given& given, SolidDescription& solid);  ///< "vertices", "elements", "embedding"
/// "vertices" of all paths in a row, "counts" of each
void read_rest(const Given& given, FibresDescription& fibres);
/// "formula_name", "doc", "formula", "translation_invariant"
void read_rest(const Given& given, EnergyDescription& energy);

/// Adds what a dictionary describes, of a material where it has one. `kind` is what messages call it; the
/// keys must be there.
template <typename Id, typename Description>
auto adding(Id (Scene::*add)(Description), const char* kind, auto... keys) {
  const auto read_all = [=](nb::handle entries) {
    const Given given(entries, kind);
    given.require(keys...);
    auto description = given.description<Description>();
    read_rest(given, description);
    return description;
  };
  if constexpr (requires(Description description) { description.material; })
    return [=](Scene& scene, const nb::dict& entries, const decltype(Description::material)& material) {
      Description description = read_all(entries);
      description.material = material;
      return (scene.*add)(std::move(description));
    };
  else
    return [=](Scene& scene, const nb::dict& entries) { return (scene.*add)(read_all(entries)); };
}

}  // namespace stark::bindings
