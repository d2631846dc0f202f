// Descriptions of what is added to scenes, from dictionaries of the Python front end; bodies: bodies.cpp.
#pragma once

#include <stark/sim/point_set.h>
#include <stark/sim/scene.h>

#include "given.h"
#include "with_arrays.h"

namespace stark::bindings {

/// {"name", "body", "triangles" (m, 3) or None, "rest_angles", "law", "fields", "color"}
SkinDescription skin_of(const nb::dict& given, const ShellMaterial& material);
/// {"name", "body", "vertices" of all paths in a row, "counts" of each, "bending", "rest_shape", "normal",
/// "law", "fields", "color"}
FibresDescription fibres_of(const nb::dict& given, const RodMaterial& material);
/// {"name", "formula_name", "doc", "formula", "translation_invariant", "points": [...], "values": {...}};
/// points are {"kind": "vertices" | "point" | "direction" | "embedded" | "world", "body": index, ...}
EnergyDescription energy_of(const nb::dict& given);
/// {"name", "definition", "a": frame, "b": frame, "values": {...}, "enabled"}; frames are
/// {"carrier": "world" | "body" | "patch" | "node", "body": index, "position", "rotation" (9,),
/// "vertices": (3,), "node": index}
JointDescription joint_of(const nb::dict& given);
/// {"name", "definition", "on": [(joint, coordinate)], "values": {name: number}, "enabled"}
ActuatorDescription actuator_of(const nb::dict& given);
/// {"name", "a": points, "b": [points], "patch_body", "patches" (n, 3), "break_force", "enabled"}
AttachmentDescription attachment_of(const nb::dict& given);

/// A function that adds to a scene what another one reads.
template <auto add, auto read>
struct Adding;
template <typename Id, typename Description, Id (Scene::*add)(Description), typename... Args,
          Description (*read)(Args...)>
struct Adding<add, read> {
  static Id call(Scene& scene, Args... args) { return (scene.*add)(read(args...)); }
};
template <auto add, auto read>
constexpr auto adding = &Adding<add, read>::call;

inline std::string quoted(const Scene& s, BodyId body) { return "'" + s.name(body) + "'"; }

}  // namespace stark::bindings

void bind_bodies(nanobind::class_<stark::Scene>& c);  ///< adding, rest states, pins (bodies.cpp)
