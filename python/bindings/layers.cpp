// Bindings of layers. The front end is stark/bodies/layered.py.
#include "layers.h"

#include <nanobind/stl/string.h>

#include <stark/sim/layers.h>
#include <stark/sim/lumped_mass.h>

#include "field_values.h"
#include "stepping.h"

namespace stark::bindings {

using namespace nb::literals;

namespace {

std::optional<Vec3> optional_vector(nb::handle object, const std::string& name) {
  if (object.is_none()) return std::nullopt;
  const auto column = array<Column<double>>(object, name, "three numbers");
  if (column.shape(0) != 3)
    throw InvalidArgument(name + ": got " + std::to_string(column.shape(0)) + " numbers, need three numbers");
  return Vec3{column(0), column(1), column(2)};
}

template <typename Description>
Description layer_of(const nb::dict& given, const std::string& kind) {
  Description layer;
  layer.name = nb::cast<std::string>(given["name"]);
  layer.body = {nb::cast<int32_t>(given["body"])};
  if (!given["law"].is_none()) layer.law = nb::cast<typename decltype(layer.law)::value_type>(given["law"]);
  layer.fields = parameter_values_of(given["fields"], kind);
  if (const auto color = optional_vector(given["color"], kind + ": color"))
    layer.color = Color{color->x, color->y, color->z};
  return layer;
}

std::vector<Mat3> initial_frames(const Scene& scene, int32_t k) {
  const FibresDescription& fibres = scene.fibres(FibresId{k});
  std::vector<Mat3> frames;
  if (!fibres.bending) return frames;
  for (const PathFrames& of_path : path_frames(scene, fibres))
    frames.insert(frames.end(), of_path.initial.begin(), of_path.initial.end());
  return frames;
}

}  // namespace

int32_t add_skin(Scene& scene, const nb::dict& given, const ShellMaterial& material) {
  auto skin = layer_of<SkinDescription>(given, "skin");
  skin.material = material;
  if (!given["triangles"].is_none()) {
    const auto triangles =
        array<Rows<int32_t, 3>>(given["triangles"], "skin: triangles", "an (m, 3) array of vertices");
    const std::span<const Index3> t = rows<Index3>(triangles);
    skin.triangles.assign(t.begin(), t.end());
  }
  skin.rest_angles = nb::cast<std::string>(given["rest_angles"]) == to_string(RestAngles::Flat)
                         ? RestAngles::Flat
                         : RestAngles::Mesh;
  return scene.add_skin(std::move(skin)).index;
}

int32_t add_fibres(Scene& scene, const nb::dict& given, const RodMaterial& material) {
  auto fibres = layer_of<FibresDescription>(given, "fibres");
  fibres.material = material;
  const auto vertices =
      array<Column<int32_t>>(given["vertices"], "fibres: vertices of paths", "a row of vertex indices");
  const std::span<const int32_t> all = values(vertices);
  size_t first = 0;
  for (nb::handle count : nb::cast<nb::list>(given["counts"])) {
    const auto path = all.subspan(first, nb::cast<size_t>(count));
    fibres.paths.emplace_back(path.begin(), path.end());
    first += path.size();
  }
  fibres.bending = nb::cast<bool>(given["bending"]);
  fibres.rest_shape = nb::cast<std::string>(given["rest_shape"]) == to_string(RestShape::Straight)
                          ? RestShape::Straight
                          : RestShape::Mesh;
  fibres.normal = optional_vector(given["normal"], "fibres: normal");
  return scene.add_fibres(std::move(fibres)).index;
}

void bind_layers_of_scene(nb::handle type) {
  nb::borrow<nb::class_<Scene>>(type)
      .def("add_skin", &add_skin, "description"_a, "material"_a, "Adds a skin; returns its index.")
      .def("add_fibres", &add_fibres, "description"_a, "material"_a, "Adds fibres; returns their index.")
      .def(
          "skin_name", [](const Scene& s, int32_t k) { return s.skin(SkinId{k}).name; }, "skin"_a)
      .def(
          "fibres_name", [](const Scene& s, int32_t k) { return s.fibres(FibresId{k}).name; }, "fibres"_a)
      .def(
          "skin_mass", [](const Scene& s, int32_t k) { return total_mass(s, s.skin(SkinId{k})); }, "skin"_a)
      .def(
          "fibres_mass", [](const Scene& s, int32_t k) { return total_mass(s, s.fibres(FibresId{k})); },
          "fibres"_a)
      .def(
          "mass", [](const Scene& s, int32_t body) { return total_mass(s, BodyId{body}); }, "body"_a,
          "Of a body with all of its layers [kg].")
      .def(
          "initial_fibre_frames",
          [](const Scene& s, int32_t k) { return to_numpy<double>(initial_frames(s, k)); }, "fibres"_a,
          "Frames of the nodes at time 0, path by path (n, 3, 3).");
}

void bind_layers_of_simulation(nb::handle type) {
  nb::borrow<nb::class_<Simulation>>(type)
      .def_prop_ro("skin_count", [](const Simulation& s) { return s.scene().skins().size(); })
      .def_prop_ro("fibres_count", [](const Simulation& s) { return s.scene().fibres().size(); })
      .def(
          "fibre_frames",
          [](const Simulation& s, int32_t k) { return to_numpy<double>(s.frames(FibresId{k})); }, "fibres"_a,
          "Frames of the nodes, path by path (n, 3, 3).");
}

}  // namespace stark::bindings
