// What the stages of the rasteriser share: the meshes as one list of triangles with a normal per corner.
#pragma once

#include <array>
#include <cmath>
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

/// Samples of the unit disk: equal areas, no two in a line. In polar coordinates.
struct DiskSample {
  double radius, angle;
};
inline DiskSample disk_sample(int i, int count) {
  constexpr double kGoldenAngle = 2.399963229728653;
  return {std::sqrt((i + 0.5) / count), kGoldenAngle * i};
}

/// Depth map of a light over a square around the scene; depth grows away from the light.
class ShadowMap {
 public:
  /// `towards_light` is a unit vector, `reach` half the side of the square [m]. `spread` is the tangent of
  /// the half angle under which the light is seen; 0: as a point, with sharp shadows.
  ShadowMap(const Vec3& towards_light, const Vec3& center, double reach, int resolution, double spread = 0.0);

  void draw(std::span<const Triangle> triangles);

  /// Share of the light in [0, 1] that arrives at a point; 1 outside the square. `normal` must look towards
  /// the light's side; the point is lifted along it against self-shadowing.
  double visibility(const Vec3& point, const Vec3& normal) const;

  const Vec3& towards_light() const { return towards_light_; }

 private:
  /// Where a point is on the map [texels], and its depth [m]; the plane that it lies in gets deeper by
  /// `slope` from texel to texel.
  struct Place {
    double x, y, depth;
    std::array<double, 2> slope;
  };
  Place place_of(const Vec3& point, const Vec3& normal) const;
  bool is_inside(const Place& place) const;
  double texel() const { return 2.0 * reach_ / resolution_; }

  /// Of the texels within a radius of blur: the nearest depth, or one nearer still.
  float nearest_around(const Place& place) const;
  /// Filtered over 2x2 texels.
  double sharp(const Place& place) const;
  /// Filtered over the penumbra of what is in the way.
  double blurred(const Place& place) const;
  /// Radius of the penumbra of what is at a depth [texels].
  double penumbra(const Place& place, double depth) const;
  /// What is in the way within a radius [texels]: the share of the samples, and its mean depth [m].
  struct Blockers {
    double share = 0.0, depth = 0.0;
  };
  Blockers look(const Place& place, double radius, std::span<const std::array<double, 2>> samples) const;
  void find_nearest();

  Vec3 towards_light_, right_, up_, center_;
  double reach_, spread_;
  int resolution_;
  std::vector<float> depth_;
  std::vector<float> nearest_;  ///< by tile, of it and those around
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
