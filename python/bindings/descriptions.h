// Descriptions of what is added to scenes, from dictionaries of the Python front end; bodies: bodies.cpp.
#pragma once

#include <stark/sim/description_fields.h>
#include <stark/sim/point_set.h>
#include <stark/sim/scene.h>

#include "given.h"
#include "with_arrays.h"

namespace stark::bindings {

/// What a description declares (sim/description_fields.h), by the names of its members.
template <typename Description>
Description description_of(const Given& given) {
  Description description;
  for_each_field(description, [&](const char* name, auto& member) { given.read(name, member); });
  return description;
}

// Further entries than those, of each kind.
SkinDescription skin_of(const nb::dict& given, const ShellMaterial& material);
SkinDescription skin_of(const nb::dict& given, const ShellMaterial& material);
/// {"vertices" of all paths in a row, "counts" of each}
FibresDescription fibres_of(const nb::dict& given, const RodMaterial& material);
/// {"formula_name", "doc", "formula", "translation_invariant", "points": [...]}; points are {"kind":
/// "vertices" | "point" | "direction" | "embedded" | "world", "body": index, ...}
EnergyDescription energy_of(const nb::dict& given);
/// {"a": frame, "b": frame}; frames are {"carrier": "world" | "body" | "patch" | "node", "body": index,
/// "position", "rotation" (9,), "vertices": (3,), "node": index}
JointDescription joint_of(const nb::dict& given);
/// {"on": [(joint, coordinate)]}
ActuatorDescription actuator_of(const nb::dict& given);
/// {"a": points, "b": [points], "patches" (n, 3)}
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
