// Shading stage of the software rasteriser, and its entry point; the other stages are in io/detail.
#include <stark/io/raster.h>

#include <algorithm>
#include <atomic>
#include <numbers>
#include <string>

#include <stark/base/error.h>
#include <stark/base/smooth_step.h>
#include <stark/base/thread_pool.h>
#include <stark/io/detail/raster_scene.h>

namespace stark {
namespace {

using raster::CameraFrame;
using raster::ShadowMap;
using raster::TriangleScene;
using raster::VisibilityBuffer;

/// Samples of the key light lie in a cone of this half angle [rad]: it sets the softness of its shadows.
constexpr double kKeyLightRadius = 0.06;
constexpr double kOverlap = 1.3;  ///< radius of what a sample stands for, over that of its share of the area
const Vec3 kKeyColor{0.84, 0.81, 0.765}, kSkyColor{0.40, 0.425, 0.46}, kEarthColor{0.22, 0.205, 0.19};
const Vec3 kGroundColor{0.80, 0.81, 0.83};  // sRGB

Vec3 multiply(const Vec3& a, const Vec3& b) { return {a.x * b.x, a.y * b.y, a.z * b.z}; }
Vec3 mix(const Vec3& a, const Vec3& b, double t) { return a + t * (b - a); }
double smoothstep(double low, double high, double x) { return smooth_step((x - low) / (high - low)); }

double linear_from_srgb(double c) { return c <= 0.04045 ? c / 12.92 : std::pow((c + 0.055) / 1.055, 2.4); }
Vec3 linear_from_srgb(const Vec3& c) {
  return {linear_from_srgb(c.x), linear_from_srgb(c.y), linear_from_srgb(c.z)};
}
uint8_t byte_from_linear(double c) {
  const double s = c <= 0.0031308 ? 12.92 * c : 1.055 * std::pow(c, 1.0 / 2.4) - 0.055;
  return static_cast<uint8_t>(std::clamp(255.0 * s + 0.5, 0.0, 255.0));
}

/// Whether the picture is wanted no more. The question goes to the caller, so only its thread asks.
class Breaks {
 public:
  explicit Breaks(const std::function<bool()>& interrupted) : interrupted_(interrupted) {}

  bool is_over() const { return over_.load(std::memory_order_relaxed); }
  bool is_over(int thread) {
    if (thread == 0 && interrupted_ && !is_over() && interrupted_()) over_.store(true);
    return is_over();
  }

 private:
  const std::function<bool()>& interrupted_;
  std::atomic<bool> over_ = false;
};

/// The lights and their shadow maps.
class Lighting {
 public:
  Lighting(const TriangleScene& scene, const RasterSettings& settings, ThreadPool& pool, Breaks& breaks)
      : key_(normalized(settings.light)), key_count_(settings.key_lights) {
    const double reach = 1.9 * settings.scene_radius;
    const Vec3 side =
        normalized(std::fabs(key_.z) < 0.9 ? cross(key_, Vec3{0, 0, 1}) : cross(key_, Vec3{0, 1, 0}));
    const Vec3 other = cross(key_, side);
    // Each sample stands for its part of the light, so that shadows do not show as many copies.
    const double key_spread = kKeyLightRadius * kOverlap / std::sqrt(std::max(1, settings.key_lights));
    const double sky_spread = std::sqrt(2.0 / std::max(1, settings.sky_lights)) * kOverlap;
    for (int i = 0; i < settings.key_lights; ++i) {
      const auto [share, a] = raster::disk_sample(i, settings.key_lights);
      const double r = kKeyLightRadius * share;
      maps_.emplace_back(normalized(key_ + (r * std::cos(a)) * side + (r * std::sin(a)) * other),
                         settings.scene_center, reach, 1024, key_spread);
    }
    // Equal areas of the upper hemisphere, so that the sum over the lights is the integral over the sky.
    for (int i = 0; i < settings.sky_lights; ++i) {
      const double z = (i + 0.5) / settings.sky_lights, r = std::sqrt(1.0 - z * z);
      const double a = raster::disk_sample(i, settings.sky_lights).angle;
      maps_.emplace_back(Vec3{r * std::cos(a), r * std::sin(a), z}, settings.scene_center, reach, 512,
                         sky_spread);
    }
    pool.for_each_task(static_cast<int64_t>(maps_.size()), [&](int64_t i, int thread) {
      if (!breaks.is_over(thread)) maps_[i].draw(scene.triangles);
    });
  }

  /// Light that a white diffuse surface sends back, and the visible share of the key light. `face` is the
  /// normal of the triangle, `normal` the smooth one; both look towards the viewer.
  Vec3 diffuse(const Vec3& point, const Vec3& normal, const Vec3& face, double& out_key) const {
    const double cosine = std::max(0.0, dot(normal, key_));
    double visible = 1.0;
    if (key_count_ > 0 && cosine > 0.0) {
      visible = 0.0;
      for (int i = 0; i < key_count_; ++i) visible += maps_[i].visibility(point, face);
      visible /= key_count_;
    }
    // A smooth normal may see the light although its triangle does not: both have a say, or the border would
    // be jagged.
    visible *= smoothstep(-0.05, 0.12, dot(normal, key_));
    out_key = visible;
    const int sky_count = static_cast<int>(maps_.size()) - key_count_;
    double sky = 0.5 + 0.5 * normal.z, openness = 1.0;
    if (sky_count > 0) {
      double sum = 0.0, total = 0.0, open = 0.0;
      for (int i = key_count_; i < key_count_ + sky_count; ++i) {
        const double weight = dot(normal, maps_[i].towards_light());
        if (weight <= 0.0) continue;
        const double share = maps_[i].visibility(point, face);
        sum += weight * share;
        open += share;
        total += 1.0;
      }
      sky = 2.0 * sum / sky_count;  // the mean of max(0, n.l) over the hemisphere is 1/2 for n = up
      openness = total > 0.0 ? open / total : 0.5;
    }
    const double earth = (0.5 - 0.5 * normal.z) * (0.4 + 0.6 * openness);
    return (cosine * visible) * kKeyColor + sky * kSkyColor + (earth + 0.06) * kEarthColor;
  }

  const Vec3& key() const { return key_; }

 private:
  Vec3 key_;
  int key_count_;
  std::vector<ShadowMap> maps_;
};

class Shader {
 public:
  Shader(std::span<const RasterMesh> meshes, const TriangleScene& scene, const CameraFrame& frame,
         const RasterSettings& settings, const Lighting& lighting)
      : meshes_(meshes),
        scene_(scene),
        frame_(frame),
        settings_(settings),
        lighting_(lighting),
        top_(linear_from_srgb(settings.background_top)),
        bottom_(linear_from_srgb(settings.background_bottom)),
        ground_(linear_from_srgb(kGroundColor)),
        pixel_angle_(2.0 * frame.half_height / settings.height) {
    for (const RasterMesh& mesh : meshes) colors_.push_back(linear_from_srgb(mesh.color));
  }

  /// Linear colour of the sample at picture coordinates x, y in [0, 1] that shows a triangle (-1: none).
  Vec3 shade(double x, double y, int32_t triangle) const {
    const Vec3 ray = frame_.ray(x, y), background = mix(top_, bottom_, y);
    if (triangle < 0) return shade_ground(ray, background, lit_ground(ray));
    const raster::Triangle& t = scene_.triangles[triangle];
    const RasterMesh& mesh = meshes_[t.mesh];
    const double along = dot(ray, t.normal);
    if (along == 0.0) return background;
    const Vec3 point = frame_.eye + (dot(t.corners[0] - frame_.eye, t.normal) / along) * ray;
    const std::array<double, 3> b = barycentric(t, point);
    const auto& n = scene_.corner_normals[triangle];
    Vec3 normal = b[0] * n[0] + b[1] * n[1] + b[2] * n[2];
    normal = squared_norm(normal) > 0.0 ? normalized(normal) : t.normal;
    const bool back = along > 0.0;
    const Vec3 face = back ? -t.normal : t.normal;
    if (dot(normal, face) < 0.0) normal = -normal;
    Vec3 base = colors_[t.mesh];
    if (mesh.fades_out && std::fabs(t.normal.z) > 0.999) base = base * (1.0 - grid_darkness(point, ray));
    if (back && mesh.pale_back) base = mix(base, 1.15 * dot(base, {0.3, 0.55, 0.15}) * Vec3{1, 1, 1}, 0.35);
    if (settings_.edges && mesh.outlined && !mesh.fades_out)
      base = base * (1.0 - 0.45 * edge_coverage(t, point));
    double key = 1.0;
    const Vec3 light = lighting_.diffuse(rounded(t, n, b, point, face), normal, face, key);
    const Vec3 view = normalized(-ray);
    const double gloss =
        0.10 * key * std::pow(std::max(0.0, dot(normal, normalized(lighting_.key() + view))), 42.0);
    Vec3 color = tone(multiply(base, light) + Vec3{gloss, gloss, gloss});
    if (mesh.fades_out) color = mix(color, background, horizon(point));
    return color;
  }

  /// Linear colour of a pixel of samples x samples that shows no triangle, with its upper left corner at x, y
  /// and of the size dx, dy: the light of its middle, the lines of the ground at every sample.
  Vec3 shade_empty(double x, double y, double dx, double dy) const {
    const int n = settings_.samples;
    const Vec3 ground = lit_ground(frame_.ray(x + 0.5 * dx, y + 0.5 * dy));
    Vec3 color;
    for (int i = 0; i < n * n; ++i) {
      const double sx = x + (i % n + 0.5) / n * dx, sy = y + (i / n + 0.5) / n * dy;
      color += shade_ground(frame_.ray(sx, sy), mix(top_, bottom_, sy), ground);
    }
    return 1.0 / (n * n) * color;
  }

 private:
  static Vec3 tone(const Vec3& c) {
    const auto curve = [](double v) { return 1.18 * v / (1.0 + 0.22 * v); };
    return {curve(c.x), curve(c.y), curve(c.z)};
  }

  double horizon(const Vec3& point) const {
    return smoothstep(0.35, 1.0, norm(point - settings_.scene_center) / (9.0 * settings_.scene_radius));
  }

  static std::array<double, 3> barycentric(const raster::Triangle& t, const Vec3& p) {
    const Vec3 u = t.corners[1] - t.corners[0], v = t.corners[2] - t.corners[0], w = p - t.corners[0];
    const double inverse_area = 1.0 / dot(cross(u, v), t.normal);
    const double b1 = std::clamp(dot(cross(w, v), t.normal) * inverse_area, 0.0, 1.0);
    const double b2 = std::clamp(dot(cross(u, w), t.normal) * inverse_area, 0.0, 1.0);
    return {std::max(0.0, 1.0 - b1 - b2), b1, b2};
  }

  /// A point of a triangle, moved out to the round surface that its corner normals (towards the viewer on the
  /// side of `face`) describe, so that shadows end where the surface turns from the light, not at edges of
  /// triangles. [Hanika 2021, "Hacking the shadow terminator", in Ray Tracing Gems II]
  static Vec3 rounded(const raster::Triangle& t, const std::array<Vec3, 3>& normals,
                      const std::array<double, 3>& weights, const Vec3& point, const Vec3& face) {
    Vec3 shift;
    for (int i = 0; i < 3; ++i) {
      const Vec3 n = dot(normals[i], face) < 0.0 ? -normals[i] : normals[i];
      shift += (weights[i] * std::max(0.0, -dot(point - t.corners[i], n))) * n;
    }
    return point + shift;
  }

  /// 1 on a mesh edge, falling to 0 within about a pixel.
  double edge_coverage(const raster::Triangle& t, const Vec3& p) const {
    const double pixel = pixel_angle_ * dot(p - frame_.eye, frame_.forward);  // [m]
    double nearest = 1e300;
    for (int e = 0; e < 3; ++e) {
      const Vec3& a = t.corners[e];
      const Vec3 along = t.corners[(e + 1) % 3] - a;
      nearest = std::min(nearest, norm(cross(p - a, along)) / std::max(norm(along), 1e-300));
    }
    return 1.0 - smoothstep(0.25 * pixel, 0.9 * pixel, nearest);
  }

  /// Where a ray meets the ground before it fades out; false where it does not.
  bool on_ground(const Vec3& ray, Vec3& out_point, double& out_fade) const {
    const double height = frame_.eye.z - settings_.ground_height;
    if (!settings_.ground || ray.z * height >= 0.0) return false;
    out_point = frame_.eye - (height / ray.z) * ray;
    out_fade = horizon(out_point);
    return out_fade < 1.0;
  }

  /// Light of the ground without its lines.
  Vec3 lit_ground(const Vec3& ray) const {
    Vec3 point;
    double fade = 1.0, key = 1.0;
    if (!on_ground(ray, point, fade)) return ground_;
    const Vec3 normal{0.0, 0.0, frame_.eye.z > settings_.ground_height ? 1.0 : -1.0};
    return tone(multiply(ground_, lighting_.diffuse(point, normal, normal, key)));
  }

  Vec3 shade_ground(const Vec3& ray, const Vec3& background, const Vec3& lit) const {
    Vec3 point;
    double fade = 1.0;
    if (!on_ground(ray, point, fade)) return background;
    return mix((1.0 - grid_darkness(point, ray)) * lit, background, fade);
  }

  double grid_darkness(const Vec3& point, const Vec3& ray) const {
    if (settings_.grid_spacing <= 0.0) return 0.0;
    const double footprint = pixel_angle_ * dot(point - frame_.eye, frame_.forward);  // of a pixel [m]
    const double slant = std::min(1.0, std::fabs(ray.z) / norm(ray));
    const double fine = grid_line(point, settings_.grid_spacing, footprint, slant);
    const double coarse = grid_line(point, 10.0 * settings_.grid_spacing, footprint, slant);
    return std::max(0.10 * fine, 0.20 * coarse);
  }

  static double grid_line(const Vec3& p, double spacing, double footprint, double slant) {
    const double width = footprint / spacing, stretched = width / std::max(slant, 0.02);
    const double fade = std::clamp(1.0 - 2.5 * stretched, 0.0, 1.0);
    double nearest = 1.0;
    for (const double v : {p.x / spacing, p.y / spacing})
      nearest = std::min(nearest, std::fabs(v - std::round(v)));
    return fade * (1.0 - smoothstep(0.4 * width, 1.1 * stretched, nearest));
  }

  std::span<const RasterMesh> meshes_;
  const TriangleScene& scene_;
  const CameraFrame& frame_;
  const RasterSettings& settings_;
  const Lighting& lighting_;
  Vec3 top_, bottom_, ground_;
  double pixel_angle_;
  std::vector<Vec3> colors_;
};

void check(const RasterCamera& camera, const RasterSettings& s) {
  const auto need = [](bool good, const std::string& message) {
    if (!good) throw InvalidArgument(message);
  };
  constexpr int kLargest = 16384;
  for (const int size : {s.width, s.height})
    need(size >= 1 && size <= kLargest, "picture: size " + std::to_string(s.width) + " x " +
                                            std::to_string(s.height) + " px; must be in [1, 16384]");
  need(s.samples >= 1 && s.samples <= 8,
       "picture: samples = " + std::to_string(s.samples) + " per pixel and axis; must be in [1, 8]");
  need(s.key_lights >= 0 && s.key_lights <= 256 && s.sky_lights >= 0 && s.sky_lights <= 1024,
       "picture: key_lights must be in [0, 256] and sky_lights in [0, 1024]");
  need(is_finite(camera.eye) && is_finite(camera.target) && is_finite(camera.up),
       "camera: a vector is not finite");
  need(camera.eye != camera.target, "camera: eye and target are the same point; move one of them");
  need(camera.vertical_fov > 0.0 && camera.vertical_fov < 3.1,
       "camera: field of view = " + std::to_string(camera.vertical_fov) + " rad; must be in (0, 3.1)");
  need(s.scene_radius > 0.0 && std::isfinite(s.scene_radius) && is_finite(s.scene_center),
       "picture: scene radius = " + std::to_string(s.scene_radius) + " m; must be positive and finite");
  need(is_finite(s.light) && squared_norm(s.light) > 0.0, "picture: the light's direction must not be zero");
}

}  // namespace

Image rasterise(std::span<const RasterMesh> meshes, const RasterCamera& camera,
                const RasterSettings& settings, const std::function<bool()>& interrupted) {
  check(camera, settings);
  Breaks breaks(interrupted);
  ThreadPool pool(usable_threads(settings.threads));
  const TriangleScene scene = raster::flatten(meshes);
  const CameraFrame frame(camera, static_cast<double>(settings.width) / settings.height);
  const Lighting lighting(scene, settings, pool, breaks);
  if (breaks.is_over(0)) return {};
  const int n = settings.samples, width = settings.width, height = settings.height;
  const VisibilityBuffer visible =
      raster::draw_visibility(scene, frame, width * n, height * n, 1e-3 * settings.scene_radius, pool);
  const Shader shader(meshes, scene, frame, settings, lighting);

  Image image{width, height, std::vector<uint8_t>(static_cast<size_t>(width) * height * 3)};
  constexpr int kRows = 8;
  pool.for_each_task((height + kRows - 1) / kRows, [&](int64_t band, int thread) {
    if (breaks.is_over(thread)) return;
    for (int64_t y = band * kRows; y < std::min<int64_t>(height, (band + 1) * kRows); ++y)
      for (int x = 0; x < width; ++x) {
        const auto triangle_at = [&](int i) {
          return visible.triangle[static_cast<size_t>(y * n + i / n) * visible.width + x * n + i % n];
        };
        // A pixel that shows one triangle only is shaded once, in its middle, unless lines cross it.
        bool uniform = !settings.edges || triangle_at(0) < 0;
        for (int i = 1; i < n * n && uniform; ++i) uniform = triangle_at(i) == triangle_at(0);
        Vec3 color;
        if (uniform && triangle_at(0) < 0) {
          color = shader.shade_empty(static_cast<double>(x) / width, static_cast<double>(y) / height,
                                     1.0 / width, 1.0 / height);
        } else if (uniform) {
          color = shader.shade((x + 0.5) / width, (y + 0.5) / height, triangle_at(0));
        } else {
          for (int i = 0; i < n * n; ++i)
            color += shader.shade((x + (i % n + 0.5) / n) / width, (y + (i / n + 0.5) / n) / height,
                                  triangle_at(i));
          color *= 1.0 / (n * n);
        }
        uint8_t* pixel = &image.pixels[3 * (static_cast<size_t>(y) * width + x)];
        for (int c = 0; c < 3; ++c) pixel[c] = byte_from_linear(color[c]);
      }
  });
  if (breaks.is_over()) return {};
  return image;
}

}  // namespace stark
