// Bindings of io: the software rasteriser. stark.render is its public face.
#include <stark/io/raster.h>

#include "functions.h"
#include "without_gil.h"

namespace stark::bindings {

namespace {

/// Positions and triangles.
using Arrays = std::pair<std::vector<Vec3>, std::vector<Index3>>;

/// Picture of shape (height, width, 3), uint8 sRGB. Meshes are "positions", "triangles" and members of
/// RasterMesh by name, camera and settings those of RasterCamera and RasterSettings; lengths in metres.
auto draw(const nb::list& given_meshes, nb::handle given_camera, nb::handle given_settings) {
  std::vector<Arrays> arrays(given_meshes.size());  // they live while the rasteriser runs
  std::vector<RasterMesh> meshes;
  for (size_t k = 0; k < arrays.size(); ++k) {
    const Given given(given_meshes[k], "mesh");
    given.read("positions", arrays[k].first);
    given.read("triangles", arrays[k].second);
    RasterMesh& mesh = meshes.emplace_back(given.description<RasterMesh>());
    std::tie(mesh.positions, mesh.triangles) = arrays[k];
  }
  const auto camera = Given(given_camera, "camera").description<RasterCamera>();
  const auto settings = Given(given_settings, "picture").description<RasterSettings>();
  Signals signals;  // "best" pictures take seconds
  const auto interrupted = [&] { return signals.have_come(); };
  Image image = without_gil([&] { return rasterise(meshes, camera, settings, interrupted); });
  signals.raise_again();
  const size_t height = image.height, width = image.width;
  return to_numpy(std::move(image.pixels), {height, width, 3});
}

}  // namespace

void bind_io(nb::module_& m) { def<draw>(m, {"meshes", "camera", "settings"}); }

}  // namespace stark::bindings
