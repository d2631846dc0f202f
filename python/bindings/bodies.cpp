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

template <typename Description>
Description body_of(const Given& given) {
  auto body = description_of<Description>(given);
  given.read("vertices", body.mesh.vertices);
  if constexpr (requires { body.mesh.triangles; }) given.read("triangles", body.mesh.triangles);
  return body;
}

template <typename Description, typename Material>
Description deformable_of(const Given& given, const Material& material) {
  auto body = body_of<Description>(given);
  body.material = material;
  return body;
}

ClothDescription cloth_of(const nb::dict& entries, const ShellMaterial& material) {
  return deformable_of<ClothDescription>(given_of(entries, "cloth"), material);
}

SolidDescription solid_of(const nb::dict& entries, const SolidMaterial& material) {
  const Given given = given_of(entries, "solid");
  auto body = deformable_of<SolidDescription>(given, material);
  read_elements(entries["elements"], given.owner() + ": elements", body.mesh);
  if (const nb::object embedding = given.find("embedding"))
    body.mesh.embedding = embedding_of(nb::cast<nb::dict>(embedding), given.owner());
  return body;
}

RodDescription rod_of(const nb::dict& entries, const RodMaterial& material) {
  return deformable_of<RodDescription>(given_of(entries, "rod"), material);
}

RigidDescription rigid_of(const nb::dict& entries) {
  const Given given = given_of(entries, "rigid body");
  auto body = body_of<RigidDescription>(given);
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
