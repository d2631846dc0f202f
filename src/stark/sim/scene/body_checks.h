// Checks that bodies of all kinds share. Internal to sim.
#pragma once

#include <algorithm>
#include <span>
#include <string>
#include <utility>
#include <vector>

#include <stark/geometry/topology.h>
#include <stark/sim/scene/scene.h>
#include <stark/sim/scene/validation.h>

namespace stark {

inline std::string owner_text(BodyKind kind, const std::string& name) {
  return std::string(row_of(kind).title) + " '" + name + "'";
}

/// What all kinds of bodies share.
template <typename Description>
void check_common(const std::string& owner, const Description& body) {
  check_finite(owner, "position", body.position, "m");
  check_rotation(owner, body.rotation);
  check_finite(owner, "velocity", body.velocity, "m/s");
  check_finite(owner, "angular_velocity", body.angular_velocity, "rad/s");
  if (body.contact_distance)
    check_number(owner, "contact_distance", *body.contact_distance, "m", positive(),
                 "leave it out to use contact.distance of the settings");
  if (body.contact_stiffness)
    check_number(owner, "contact_stiffness", *body.contact_stiffness, "Pa", positive(),
                 "leave it out to use contact.stiffness of the settings");
  if (body.contact_core != 0.0)
    check_number(owner, "contact_core", body.contact_core, "m",
                 closed_interval(0.0, 0.5 * body.contact_distance.value_or(0.0)),
                 "give a contact_distance of at least twice the core");
  if (body.friction)
    check_number(owner, "friction", *body.friction, "1", non_negative(),
                 "leave it out to use the scene's default");
  if (body.color)
    for (double channel : *body.color)
      check_number(owner, "color channel", channel, "1", closed_interval(0.0, 1.0),
                   "give red, green, blue in [0, 1]");
}

/// A mesh of a hundred metres is usually one in millimetres.
inline void warn_about_size(const std::string& owner, std::span<const Vec3> vertices,
                            std::vector<std::string>& warnings) {
  const double extent = max_abs(box_size(vertices));
  if (extent > 100.0 || extent < 1e-4)
    warnings.push_back(owner + ": the mesh has an extent of " + rough_text(extent, "m") +
                       "; if it is not in metres, scale it with mesh.scaled(factor)");
}

/// Appends those that are not there yet.
inline void append_new(std::vector<int32_t>& list, std::span<const int32_t> additions) {
  const int32_t count = additions.empty() ? 0 : *std::max_element(additions.begin(), additions.end()) + 1;
  std::vector<char> known(static_cast<size_t>(count), 0);
  for (const int32_t v : list)
    if (v < count) known[v] = 1;
  for (const int32_t v : additions)
    if (!std::exchange(known[v], 1)) list.push_back(v);
}

}  // namespace stark
