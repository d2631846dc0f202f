// What the stages of the rasteriser share: the meshes as one list of triangles with a normal per corner.
#pragma once

#include <array>
#include <cstdint>
#include <span>
#include <vector>

#include <stark/base/math.h>
#include <stark/base/thread_pool.h>
#include <stark/io/raster.h>

namespace stark::raster {

struct Triangle {
  std::array<Vec3, 3> corners;  ///< [m]
  Vec3 normal;                  ///< unit, zero for a triangle without area
  int32_t mesh = 0;
};

struct TriangleScene {
  std::vector<Triangle> triangles;
  std::vector<std::array<Vec3, 3>>
      corner_normals;  ///< unit, smooth across edges below the mesh's crease angle
};

/// Checks the meshes and flattens them. Throws InvalidArgument.
TriangleScene flatten(std::span<const RasterMesh> meshes);

/// Depth map of a directional light over a square around the scene; depth grows away from the light.
class ShadowMap {
 public:
  /// `towards_light` is a unit vector, `reach` half the side of the square [m].
  ShadowMap(const Vec3& towards_light, const Vec3& center, double reach, int resolution);

  void draw(std::span<const Triangle> triangles);

  /// Share of the light in [0, 1] that arrives at a point, filtered over 2x2 texels; 1 outside the square.
  /// `normal` must look towards the light's side; the point is lifted along it against self-shadowing.
  double visibility(const Vec3& point, const Vec3& normal) const;

  const Vec3& towards_light() const { return towards_light_; }

 private:
  Vec3 towards_light_, right_, up_, center_;
  double reach_;
  int resolution_;
  std::vector<float> depth_;
};

/// Visible triangle of every sample: index into TriangleScene::triangles, or -1.
struct VisibilityBuffer {
  int width = 0, height = 0;  ///< in samples
  std::vector<float> inverse_depth;
  std::vector<int32_t> triangle;
};

/// Orthonormal camera frame with the extent of the picture at unit distance.
struct CameraFrame {
  CameraFrame(const RasterCamera& camera, double aspect);
  /// Direction through picture coordinates x, y in [0, 1] from the top left; its component along `forward`
  /// is 1.
  Vec3 ray(double x, double y) const {
    return forward + ((2.0 * x - 1.0) * half_width) * right + ((1.0 - 2.0 * y) * half_height) * up;
  }
  Vec3 eye, forward, right, up;
  double half_width, half_height;
};

VisibilityBuffer draw_visibility(const TriangleScene& scene, const CameraFrame& frame, int width, int height,
                                 double near_distance, ThreadPool& pool);

}  // namespace stark::raster
