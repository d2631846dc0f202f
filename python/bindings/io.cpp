// Bindings of io: the software rasteriser. stark.render is its public face.
#include <utility>

#include <stark/io/raster.h>

#include "with_arrays.h"
#include "without_gil.h"

namespace stark::bindings {

namespace {

/// Keeps what is drawn, also while the rasteriser runs without the interpreter's lock.
struct Canvas {
  std::vector<RasterMesh> meshes;
  std::vector<std::pair<std::vector<Vec3>, std::vector<Index3>>> arrays;
  RasterSettings settings;
  RasterCamera camera;
};

void add_mesh(Canvas& canvas, std::vector<Vec3>& positions, std::vector<Index3>& triangles, const Vec3& color,
              double crease_angle, bool pale_back, bool fades_out, bool outlined) {
  const auto& [p, t] = canvas.arrays.emplace_back(std::move(positions), std::move(triangles));
  canvas.meshes.push_back({p, t, color, crease_angle, pale_back, fades_out, outlined});
}

nb::object draw(const Canvas& canvas) {
  Image image = without_gil([&] { return rasterise(canvas.meshes, canvas.camera, canvas.settings); });
  const size_t height = image.height, width = image.width;
  return nb::cast(to_numpy(std::move(image.pixels), {height, width, 3}));
}

/// A member of the settings or of the camera.
template <auto part, auto member>
void def_member(nb::class_<Canvas>& canvas, const char* name) {
  using Value = std::remove_cvref_t<decltype(std::declval<Canvas&>().*part.*member)>;
  canvas.def_prop_rw(name, path<part, member>,
                     [](Canvas& c, const Value& value) { c.*part.*member = value; });
}

}  // namespace

void bind_io(nb::module_& m) {
  nb::class_<Canvas> canvas(m, "Canvas",
                            "Meshes, camera and light of one picture; lengths in metres, colours sRGB.");
  canvas.def(nb::init<>())
      .def("add_mesh",
           with_arrays<add_mesh, "positions: an (n, 3) array of numbers [m]",
                       "triangles: an (m, 3) array of vertex indices", "color">,
           "positions"_a, "triangles"_a, nb::kw_only(), "color"_a, "crease_angle"_a = 0.65,
           "pale_back"_a = false, "fades_out"_a = false, "outlined"_a = true)
      .def("draw", &draw, "Picture of shape (height, width, 3), uint8 sRGB.");
  constexpr auto settings = &Canvas::settings;
  def_member<settings, &RasterSettings::width>(canvas, "width");
  def_member<settings, &RasterSettings::height>(canvas, "height");
  def_member<settings, &RasterSettings::samples>(canvas, "samples");
  def_member<settings, &RasterSettings::scene_center>(canvas, "scene_center");
  def_member<settings, &RasterSettings::scene_radius>(canvas, "scene_radius");
  def_member<settings, &RasterSettings::light>(canvas, "light");
  def_member<settings, &RasterSettings::key_lights>(canvas, "key_lights");
  def_member<settings, &RasterSettings::sky_lights>(canvas, "sky_lights");
  def_member<settings, &RasterSettings::ground>(canvas, "ground");
  def_member<settings, &RasterSettings::ground_height>(canvas, "ground_height");
  def_member<settings, &RasterSettings::grid_spacing>(canvas, "grid_spacing");
  def_member<settings, &RasterSettings::edges>(canvas, "edges");
  def_member<settings, &RasterSettings::background_top>(canvas, "background_top");
  def_member<settings, &RasterSettings::background_bottom>(canvas, "background_bottom");
  def_member<settings, &RasterSettings::threads>(canvas, "threads");
  def_member<&Canvas::camera, &RasterCamera::eye>(canvas, "eye");
  def_member<&Canvas::camera, &RasterCamera::target>(canvas, "target");
  def_member<&Canvas::camera, &RasterCamera::up>(canvas, "up");
  def_member<&Canvas::camera, &RasterCamera::vertical_fov>(canvas, "vertical_fov");
}

}  // namespace stark::bindings
