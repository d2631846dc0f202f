// Descriptions of what is added to scenes, from dictionaries of the Python front end: their fields
// (sim/scene/description_fields.h) by name, and what those are made of.
#pragma once

#include <stark/sim/scene/scene.h>

#include "solid_mesh.h"

namespace stark::bindings {

/// "node_point" and "node_direction" are points and directions with a `node`.
template <>
inline PointKind read(nb::handle kind, const std::string& name, const std::string&) {
  const auto given = nb::cast<std::string>(kind);
  const std::string subject = name + " = '" + given + "'";
  return choice_of<PointKind>(given.starts_with("node_") ? given.substr(5) : given, subject);
}

template <>
inline PointSet read(nb::handle entries, const std::string&, const std::string&) {
  const Given given(entries, "points");
  const auto points = given.description<PointSet>();
  given.require("kind");
  if (points.kind == PointKind::Embedded)
    given.require("supports", "weights");
  else
    given.require(points.kind == PointKind::Vertices ? "vertices"
                  : points.kind == PointKind::Joined ? "parts"
                                                     : "local");
  return points;
}

/// Of a node, which has an entry of that name instead of vertices, too.
template <>
inline FrameDescription read(nb::handle entries, const std::string&, const std::string&) {
  const Given given(entries, "frame");
  auto frame = given.description<FrameDescription>();
  given.require("carrier", "rotation");
  if (frame.carrier == FrameDescription::Carrier::Patch) given.require("vertices");
  if (const nb::object node = given.find("node")) frame.vertices = {nb::cast<int32_t>(node), -1, -1};
  return frame;
}

/// (joint, name)
template <>
inline CoordinateName read(nb::handle pair, const std::string&, const std::string&) {
  return {nb::cast<JointId>(pair[0]), nb::cast<std::string>(pair[1])};
}

/// (mass, centre of mass, tensor)
template <>
inline RigidInertia read(nb::handle parts, const std::string& name, const std::string&) {
  return {read<double>(parts[0], name + ".mass"), read<Vec3>(parts[1], name + ".center_of_mass"),
          read<Mat3>(parts[2], name + ".tensor")};
}

// Entries of a description beside its fields.
inline void read_rest(const Given&, const auto&) {}
/// "vertices" and "triangles" of the mesh
template <typename Body>
  requires requires(Body body) { body.mesh; }
void read_rest(const Given& given, Body& body) {
  given.read("vertices", body.mesh.vertices);
  if constexpr (requires { body.mesh.triangles; }) given.read("triangles", body.mesh.triangles);
}

inline void read_rest(const Given& given, SolidDescription& solid) { solid.mesh = solid_mesh(given); }

/// "vertices" of all paths in a row, "counts" of each
inline void read_rest(const Given& given, FibresDescription& fibres) {
  std::vector<int32_t> all, counts;
  given.read("vertices", all, "a row of vertex indices");
  given.read("counts", counts);
  auto next = all.begin();
  for (const int32_t count : counts) {
    if (count < 0 || count > all.end() - next)
      throw InvalidArgument(given.owner() + ": counts: got " + std::to_string(count) + " vertices where " +
                            std::to_string(all.end() - next) + " are left: must be those of each path");
    fibres.paths.emplace_back(next, next + count);
    next += count;
  }
}

inline void read_rest(const Given& given, EnergyDescription& energy) {
  std::string name, doc;
  given.read("formula_name", name);
  given.read("doc", doc);
  energy.potential = define_potential(name, doc, nb::cast<Formula>(given["formula"]));
  given.read("translation_invariant", energy.potential.translation_invariant);
}

/// Binds a function that adds what a dictionary describes, of a material where it has one. `kind` is what
/// messages call it; the keys must be there.
template <typename Id, typename Description>
void def_adding(nb::class_<Scene>& c, const char* name, Id (Scene::*add)(Description), const char* kind,
                auto... keys) {
  const auto read_all = [=](nb::handle entries) {
    const Given given(entries, kind);
    given.require(keys...);
    auto description = given.description<Description>();
    read_rest(given, description);
    return description;
  };
  if constexpr (requires(Description description) { description.material; }) {
    using Material = decltype(Description::material);
    const auto add_of = [=](Scene& scene, const nb::dict& entries, const Material& material) {
      Description description = read_all(entries);
      description.material = material;
      return (scene.*add)(std::move(description));
    };
    def(c, name, add_of, {"description", "material"});
  } else {
    const auto add_all = [=](Scene& scene, const nb::dict& entries) {
      return (scene.*add)(read_all(entries));
    };
    def(c, name, add_all, {"description"});
  }
}

}  // namespace stark::bindings
