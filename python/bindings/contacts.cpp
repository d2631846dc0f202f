// Contacts of the last step as arrays.
#include <nanobind/nanobind.h>

#include <stark/sim/contact_arrays.h>

#include "casters.h"
#include "domains.h"
#include "stepping.h"
#include "with_arrays.h"

namespace nb = nanobind;
using namespace nb::literals;
using namespace stark;
using namespace stark::bindings;

namespace {

nb::dict contact_dict(const Simulation& sim) {
  nb::dict dict;
  contact_arrays(sim).for_each(
      [&](const char* name, auto& array) { dict[name] = to_numpy(std::move(array)); });
  return dict;
}

}  // namespace

void bind_contacts(nb::module_& m) {
  m.def("contacts", &contact_dict, "simulation"_a,
        "The contacts of the last step: arrays with one row each; forces are on the first body.");
  m.def("contact_force", &Simulation::contact_force, "simulation"_a, "body"_a,
        "Sum of the contact forces on a body in the last step (3,) [N].");
  m.def("vertex_contact_forces", with_arrays<&Simulation::vertex_contact_forces>, "simulation"_a, "body"_a,
        "Sum of the contact forces on each vertex of a body in the last step (n, 3) [N].");
  m.def(
      "closest_points",
      [](Simulation& sim, BodyId a, BodyId b) {
        const ClosestPoints points = sim.closest_points(a, b);
        return nb::make_tuple(points.distance, points.point_a, points.point_b);
      },
      "simulation"_a, "a"_a, "b"_a, "Distance of two bodies [m], and where they are nearest [m].");
  m.def("inner_vertices", with_arrays<inner_vertices>, "simulation"_a, "body"_a,
        "Vertices inside flat faces of a rigid body, where contact never acts (n,).");
}
