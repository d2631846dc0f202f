// Bindings of io: the software rasteriser. stark.render is its public face.
#include <nanobind/nanobind.h>
#include <nanobind/ndarray.h>
#include <nanobind/stl/array.h>
#include <nanobind/stl/vector.h>

#include <array>
#include <vector>

#include <stark/base/math.h>
#include <stark/io/raster.h>

#include "arrays.h"
#include "without_gil.h"

namespace nb = nanobind;
using stark::bindings::Rows;
using stark::bindings::rows;

namespace {

using Triple = std::array<double, 3>;

stark::Vec3 vec(const Triple& a) { return {a[0], a[1], a[2]}; }

/// Keeps the arrays alive while the rasteriser runs without the interpreter's lock.
struct Canvas {
  std::vector<stark::RasterMesh> meshes;
  std::vector<std::pair<Rows<double, 3>, Rows<int32_t, 3>>> arrays;
  stark::RasterSettings settings;
  stark::RasterCamera camera;
};

void add_mesh(Canvas& canvas, nb::handle positions, nb::handle triangles, const Triple& color,
              double crease_angle, bool pale_back, bool fades_out, bool outlined) {
  auto p = stark::bindings::array<Rows<double, 3>>(positions, "positions", "an (n, 3) array of numbers [m]");
  auto t =
      stark::bindings::array<Rows<int32_t, 3>>(triangles, "triangles", "an (m, 3) array of vertex indices");
  canvas.meshes.push_back({rows<stark::Vec3>(p), rows<std::array<int32_t, 3>>(t), vec(color), crease_angle,
                           pale_back, fades_out, outlined});
  canvas.arrays.emplace_back(std::move(p), std::move(t));
}

nb::object draw(const Canvas& canvas) {
  stark::Image image;
  {
    const stark::bindings::WithoutGil without;
    image = stark::rasterise(canvas.meshes, canvas.camera, canvas.settings);
  }
  const size_t height = image.height, width = image.width;
  return nb::cast(stark::bindings::to_numpy(std::move(image.pixels), {height, width, 3}));
}

}  // namespace

void bind_io(nb::module_& m) {
  using S = stark::RasterSettings;
  nb::class_<Canvas> canvas(m, "Canvas",
                            "Meshes, camera and light of one picture; lengths in metres, colours sRGB.");
  canvas.def(nb::init<>())
      .def("add_mesh", &add_mesh, nb::arg("positions"), nb::arg("triangles"), nb::kw_only(), nb::arg("color"),
           nb::arg("crease_angle") = 0.65, nb::arg("pale_back") = false, nb::arg("fades_out") = false,
           nb::arg("outlined") = true)
      .def("draw", &draw, "Picture of shape (height, width, 3), uint8 sRGB.");
  const auto number = [&](const char* name, auto member) {
    canvas.def_prop_rw(
        name, [member](const Canvas& c) { return c.settings.*member; },
        [member](Canvas& c, std::remove_cvref_t<decltype(std::declval<S&>().*member)> v) {
          c.settings.*member = v;
        });
  };
  const auto vector = [&](const char* name, auto access) {
    canvas.def_prop_rw(
        name, [access](Canvas& c) { return Triple{access(c).x, access(c).y, access(c).z}; },
        [access](Canvas& c, const Triple& v) { access(c) = vec(v); });
  };
  number("width", &S::width);
  number("height", &S::height);
  number("samples", &S::samples);
  number("scene_radius", &S::scene_radius);
  number("key_lights", &S::key_lights);
  number("sky_lights", &S::sky_lights);
  number("ground", &S::ground);
  number("ground_height", &S::ground_height);
  number("grid_spacing", &S::grid_spacing);
  number("edges", &S::edges);
  number("threads", &S::threads);
  vector("scene_center", [](Canvas& c) -> stark::Vec3& { return c.settings.scene_center; });
  vector("light", [](Canvas& c) -> stark::Vec3& { return c.settings.light; });
  vector("background_top", [](Canvas& c) -> stark::Vec3& { return c.settings.background_top; });
  vector("background_bottom", [](Canvas& c) -> stark::Vec3& { return c.settings.background_bottom; });
  vector("eye", [](Canvas& c) -> stark::Vec3& { return c.camera.eye; });
  vector("target", [](Canvas& c) -> stark::Vec3& { return c.camera.target; });
  vector("up", [](Canvas& c) -> stark::Vec3& { return c.camera.up; });
  canvas.def_prop_rw(
      "vertical_fov", [](const Canvas& c) { return c.camera.vertical_fov; },
      [](Canvas& c, double v) { c.camera.vertical_fov = v; });
}
