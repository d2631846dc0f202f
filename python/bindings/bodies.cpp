// Bindings of bodies: descriptions of each kind from dictionaries, rest states, pins. The Python front end is
// stark/bodies.
#include <nanobind/stl/optional.h>

#include "descriptions.h"
#include "solid_mesh.h"

namespace {

using namespace nanobind::literals;
using namespace stark;
using namespace stark::bindings;
namespace nb = nanobind;

/// Fields that all bodies share.
template <typename Description>
void read_body(const Given& given, Description& body) {
  given.read("name", body.name);
  given.read("position", body.position);
  given.read("rotation", body.rotation);
  given.read("velocity", body.velocity);
  given.read("angular_velocity", body.angular_velocity);
  given.read("contact_distance", body.contact_distance);
  given.read("contact_stiffness", body.contact_stiffness);
  given.read("contact_core", body.contact_core);
  given.read("friction", body.friction);
  given.read("color", body.color);
  given.read("vertices", body.mesh.vertices);
}

/// Those of bodies that deform.
template <typename Description, typename Material>
void read_deformable(const Given& given, const Material& material, Description& body) {
  read_body(given, body);
  body.material = material;
  given.read("law", body.law);
  given.read("fields", body.fields);
  given.read("initial_positions", body.initial_positions);
  given.read("self_contact", body.self_contact);
}

ClothDescription cloth_of(const nb::dict& entries, const ShellMaterial& material) {
  const Given given = given_of(entries, "cloth");
  ClothDescription body;
  read_deformable(given, material, body);
  given.read("triangles", body.mesh.triangles);
  given.read("rest_angles", body.rest_angles);
  return body;
}

SolidDescription solid_of(const nb::dict& entries, const SolidMaterial& material) {
  const Given given = given_of(entries, "solid");
  SolidDescription body;
  read_deformable(given, material, body);
  read_elements(entries["elements"], given.owner() + ": elements", body.mesh);
  if (const nb::object embedding = given.find("embedding"))
    body.mesh.embedding = embedding_of(nb::cast<nb::dict>(embedding), given.owner());
  given.read("formulation", body.formulation);
  return body;
}

RodDescription rod_of(const nb::dict& entries, const RodMaterial& material) {
  const Given given = given_of(entries, "rod");
  RodDescription body;
  read_deformable(given, material, body);
  given.read("normal", body.normal);
  given.read("rest_shape", body.rest_shape);
  return body;
}

RigidDescription rigid_of(const nb::dict& entries) {
  const Given given = given_of(entries, "rigid body");
  RigidDescription body;
  read_body(given, body);
  given.read("triangles", body.mesh.triangles);
  given.read("motion", body.motion);
  given.read("mass", body.mass);
  given.read("density", body.density);
  given.read("hollow", body.hollow);
  given.read("linear_damping", body.linear_damping);
  given.read("angular_damping", body.angular_damping);
  if (const nb::object inertia = given.find("inertia")) {
    const std::string name = given.owner() + ": inertia.";
    body.inertia =
        RigidInertia{number_of(inertia[0], name + "mass"), vector_of(inertia[1], name + "center_of_mass"),
                     matrix_of(inertia[2], name + "tensor")};
  }
  return body;
}

}  // namespace

void bind_bodies(nb::class_<Scene>& c) {
  c.def("add_cloth", adding<&Scene::add_cloth, cloth_of>, "description"_a, "material"_a)
      .def("add_solid", adding<&Scene::add_solid, solid_of>, "description"_a, "material"_a)
      .def("add_rigid", adding<&Scene::add_rigid, rigid_of>, "description"_a)
      .def("add_rod", adding<&Scene::add_rod, rod_of>, "description"_a, "material"_a)
      .def(
          "set_rest_state",
          [](Scene& s, BodyId body, nb::handle given) {
            s.set_rest_state(body, parameter_values_of(given, quoted(s, body)));
          },
          "body"_a, "values"_a, "Fields of a rest state by name: (numbers, True).")
      .def(
          "check_rest_state",
          [](const Scene& s, BodyId body, nb::handle given) {
            s.check_rest_state(body, parameter_values_of(given, quoted(s, body)));
          },
          "body"_a, "values"_a)
      .def(
          "clamp",
          [](Scene& s, BodyId body, nb::handle nodes) {
            s.clamp(body,
                    numbers_of<int32_t>(nodes, quoted(s, body) + ": clamped nodes", "a row of indices"));
          },
          "body"_a, "nodes"_a)
      .def(
          "clamped", [](const Scene& s, BodyId body) { return to_numpy(s.pins(body).clamped); }, "body"_a)
      .def("initial_frames", with_arrays<&Scene::initial_frames>, "body"_a,
           "Frames of the nodes of a rod at time 0 (n, 3, 3).")
      .def(
          "pin",
          [](Scene& s, BodyId body, nb::handle vertices) {
            s.pin(body, numbers_of<int32_t>(vertices, quoted(s, body) + ": pinned vertices",
                                            "a row of vertex indices"));
          },
          "body"_a, "vertices"_a)
      .def("pins", [](const Scene& s, BodyId body) { return to_numpy(s.pins(body).vertices); }, "body"_a);
}
