// Software rasteriser: pictures of triangle meshes on machines without a graphics stack. Visibility by a
// z-buffer over a perspective camera; light from a soft key light and a sky, each sampled by directional
// lights with shadow maps, which gives soft shadows and ambient occlusion from one mechanism. Output only; no
// phase of the time step uses it.
#pragma once

#include <array>
#include <cstdint>
#include <functional>
#include <span>
#include <vector>

#include <stark/base/math.h>

namespace stark {

/// A mesh to draw. The spans must outlive the call of rasterise().
struct RasterMesh {
  std::span<const Vec3> positions;  ///< vertices in the world [m]
  std::span<const std::array<int32_t, 3>> triangles;
  Vec3 color{0.6, 0.6, 0.6};   ///< sRGB in [0, 1]
  double crease_angle = 0.65;  ///< sharper edges are drawn as edges [rad]; pi: all smooth
  bool pale_back = false;      ///< the side that looks along the normals' back is drawn paler
  bool fades_out = false;      ///< dissolves far from the scene, for floors and walls
  bool outlined = true;        ///< shows its edges where RasterSettings::edges asks for them
};

struct RasterCamera {
  Vec3 eye{1.0, -1.0, 0.6};    ///< [m]
  Vec3 target{0.0, 0.0, 0.0};  ///< [m]
  Vec3 up{0.0, 0.0, 1.0};
  double vertical_fov = 0.61;  ///< full angle [rad]
};

struct RasterSettings {
  int width = 1280;               ///< [px]
  int height = 720;               ///< [px]
  int samples = 2;                ///< samples per pixel and axis
  Vec3 scene_center;              ///< centre of what is looked at [m]: light and fading are laid around it
  double scene_radius = 1.0;      ///< [m]
  Vec3 light{0.42, -0.38, 0.86};  ///< direction towards the key light
  int key_lights = 16;            ///< samples of the key light; 0: no shadow of it
  int sky_lights = 48;            ///< samples of the sky; 0: no ambient occlusion
  bool ground = true;             ///< an endless ground plane
  double ground_height = 0.0;     ///< z of the ground [m]
  double grid_spacing = 0.0;      ///< distance of the lines on the ground [m]; 0: no lines
  bool edges = false;             ///< mesh edges as thin lines
  Vec3 background_top{0.985, 0.988, 0.992};  ///< sRGB
  Vec3 background_bottom{0.89, 0.91, 0.93};  ///< sRGB
  int threads = 1;                           ///< the picture does not depend on it
};

/// Calls function(name, member) for each member that is set by name.
template <typename Function>
void for_each_field(RasterMesh& mesh, Function&& function) {
  function("color", mesh.color);
  function("crease_angle", mesh.crease_angle);
  function("pale_back", mesh.pale_back);
  function("fades_out", mesh.fades_out);
  function("outlined", mesh.outlined);
}
template <typename Function>
void for_each_field(RasterCamera& camera, Function&& function) {
  function("eye", camera.eye);
  function("target", camera.target);
  function("up", camera.up);
  function("vertical_fov", camera.vertical_fov);
}
template <typename Function>
void for_each_field(RasterSettings& settings, Function&& function) {
  function("width", settings.width);
  function("height", settings.height);
  function("samples", settings.samples);
  function("scene_center", settings.scene_center);
  function("scene_radius", settings.scene_radius);
  function("light", settings.light);
  function("key_lights", settings.key_lights);
  function("sky_lights", settings.sky_lights);
  function("ground", settings.ground);
  function("ground_height", settings.ground_height);
  function("grid_spacing", settings.grid_spacing);
  function("edges", settings.edges);
  function("background_top", settings.background_top);
  function("background_bottom", settings.background_bottom);
  function("threads", settings.threads);
}

/// sRGB picture, rows from the top, three bytes a pixel.
struct Image {
  int width = 0;
  int height = 0;
  std::vector<uint8_t> pixels;
};

/// Draws the meshes. Throws InvalidArgument on sizes outside [1, 16384], indices out of range, or numbers
/// that are not finite. O(triangles * (lights + bands) + pixels * samples^2 * lights). `interrupted`, where
/// it is given, is called on this thread between parts of the picture; once it returns true, the picture is
/// given up and an empty one, of no pixels, returned.
Image rasterise(std::span<const RasterMesh> meshes, const RasterCamera& camera,
                const RasterSettings& settings, const std::function<bool()>& interrupted = {});

}  // namespace stark
