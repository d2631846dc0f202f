// Contacts of the last step as arrays.
#include <nanobind/nanobind.h>

#include <stark/sim/simulation.h>

#include "casters.h"
#include "domains.h"
#include "stepping.h"

namespace nb = nanobind;
using namespace nb::literals;
using namespace stark;
using namespace stark::bindings;

namespace {

nb::dict contact_dict(const Simulation& sim) {
  const std::vector<ContactForce> contacts = sim.contacts();
  std::vector<Index2> bodies;
  std::vector<std::array<int32_t, 4>> vertices;
  std::vector<std::array<double, 4>> weights;
  std::vector<int32_t> first_counts;
  std::vector<double> distance;
  std::vector<Vec3> point_a, point_b, normal_force, friction, slip;
  for (const ContactForce& entry : contacts) {
    const Contact& contact = entry.contact;
    bodies.push_back({contact.group_a, contact.group_b});
    first_counts.push_back(contact.side_a_count);
    std::array<int32_t, 4> own{-1, -1, -1, -1};
    std::array<double, 4> weight{};
    for (int p = 0; p < contact.point_count; ++p) {
      const int32_t group = p < contact.side_a_count ? contact.group_a : contact.group_b;
      own[p] = contact.sites[p] - sim.model().bodies()[group].first_site;
      weight[p] = contact.weights[p];
    }
    vertices.push_back(own);
    weights.push_back(weight);
    distance.push_back(contact.distance);
    point_a.push_back(entry.point_a);
    point_b.push_back(entry.point_b);
    normal_force.push_back(entry.normal_force);
    friction.push_back(entry.friction);
    slip.push_back(entry.slip);
  }
  return dict_of("bodies", to_numpy(std::move(bodies)), "vertices", to_numpy(std::move(vertices)), "weights",
                 to_numpy(std::move(weights)), "first_counts", to_numpy(std::move(first_counts)), "distances",
                 to_numpy(std::move(distance)), "points_a", to_numpy(std::move(point_a)), "points_b",
                 to_numpy(std::move(point_b)), "normal_forces", to_numpy(std::move(normal_force)),
                 "frictions", to_numpy(std::move(friction)), "slips", to_numpy(std::move(slip)));
}

auto inner_vertices(const Simulation& sim, BodyId body) {
  const int32_t first = sim.model().bodies()[body.index].first_site;
  std::vector<int32_t> inner;
  for (const int32_t v : sim.surface_mesh().inner)
    if (sim.surface_mesh().vertex_group[v] == body.index) inner.push_back(v - first);
  return to_numpy(std::move(inner));
}

}  // namespace

void bind_contacts(nb::module_& m) {
  m.def("contacts", &contact_dict, "simulation"_a,
        "The contacts of the last step: arrays with one row each; forces are on the first body.");
  m.def(
      "contact_force", [](const Simulation& sim, BodyId body) { return sim.contact_force(body); },
      "simulation"_a, "body"_a, "Sum of the contact forces on a body in the last step (3,) [N].");
  m.def(
      "closest_points",
      [](Simulation& sim, BodyId a, BodyId b) {
        const ClosestPoints points = sim.closest_points(a, b);
        return nb::make_tuple(points.distance, points.point_a, points.point_b);
      },
      "simulation"_a, "a"_a, "b"_a, "Distance of two bodies [m], and where they are nearest [m].");
  m.def("inner_vertices", &inner_vertices, "simulation"_a, "body"_a,
        "Vertices inside flat faces of a rigid body, where contact never acts (n,).");
}
