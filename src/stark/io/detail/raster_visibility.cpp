// The two z-buffers of the rasteriser: perspective for the camera, orthographic for the lights.
#include <stark/io/detail/raster_scene.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <limits>

namespace stark::raster {
namespace {

constexpr int kTile = 16;  ///< texels; the largest radius of a penumbra
constexpr double kReach =
    2.0 * kTile;                ///< along an axis, from a place to the ends of what is nearest around it
constexpr double kSharp = 1.0;  ///< radius of a penumbra [texels] that filtering 2x2 texels gives
constexpr double kSteepest =
    0.1;  ///< cosine of the light on a surface, below which it is as good as along it

template <int kCount>
std::array<std::array<double, 2>, kCount> spiral() {
  std::array<std::array<double, 2>, kCount> samples;
  for (int i = 0; i < kCount; ++i) {
    const auto [radius, angle] = disk_sample(i, kCount);
    samples[i] = {radius * std::cos(angle), radius * std::sin(angle)};
  }
  return samples;
}
const auto kFewSamples = spiral<5>();
const auto kSamples = spiral<8>();

/// A corner on the picture: x, y in samples, w linear over the picture (inverse depth, or depth for a light).
struct ScreenPoint {
  double x, y, w;
};

struct ScreenTriangle {
  std::array<ScreenPoint, 3> p;
  int32_t id;
};

/// Calls write(x, y, w) for every sample centre inside the triangle, rows in [row_begin, row_end).
template <typename Write>
void scan(const std::array<ScreenPoint, 3>& p, int width, int row_begin, int row_end, Write&& write) {
  const double area = (p[1].x - p[0].x) * (p[2].y - p[0].y) - (p[2].x - p[0].x) * (p[1].y - p[0].y);
  if (area == 0.0) return;
  const auto [x_min, x_max] = std::minmax({p[0].x, p[1].x, p[2].x});
  const auto [y_min, y_max] = std::minmax({p[0].y, p[1].y, p[2].y});
  if (x_max < 0.5 || x_min > width - 0.5 || y_max < row_begin + 0.5 || y_min > row_end - 0.5) return;
  const int x0 = static_cast<int>(std::max(0.0, std::ceil(x_min - 0.5)));
  const int x1 = static_cast<int>(std::min(width - 1.0, std::floor(x_max - 0.5)));
  const int y0 = static_cast<int>(std::max<double>(row_begin, std::ceil(y_min - 0.5)));
  const int y1 = static_cast<int>(std::min<double>(row_end - 1.0, std::floor(y_max - 0.5)));
  // Barycentric weights are affine in x: b_i = start_i + x * slope_i. Solving for the interval of each row
  // skips the empty part of the bounding box, which matters for large slanted triangles.
  for (int y = y0; y <= y1; ++y) {
    const double cy = y + 0.5;
    double low = x0, high = x1;
    std::array<double, 3> start, slope;
    for (int i = 0; i < 3; ++i) {
      const ScreenPoint &a = p[(i + 1) % 3], &b = p[(i + 2) % 3];
      slope[i] = (a.y - b.y) / area;
      start[i] = ((b.x - a.x) * (cy - a.y) - (b.y - a.y) * (0.5 - a.x)) / area;
      if (slope[i] > 0.0) low = std::max(low, std::ceil(-start[i] / slope[i] - 1e-9));
      if (slope[i] < 0.0) high = std::min(high, std::floor(-start[i] / slope[i] + 1e-9));
      if (slope[i] == 0.0 && start[i] < 0.0) high = low - 1.0;
    }
    if (!(low <= high)) continue;
    for (int x = static_cast<int>(low); x <= static_cast<int>(high); ++x) {
      double w = 0.0;
      for (int i = 0; i < 3; ++i) w += (start[i] + x * slope[i]) * p[i].w;
      write(x, y, w);
    }
  }
}

/// Cuts a triangle in camera space (x right, y up, z ahead) at z = near; returns the number of corners, 0, 3
/// or 4.
int clip_near(const std::array<Vec3, 3>& in, double near_distance, std::array<Vec3, 4>& out) {
  int count = 0;
  for (int i = 0; i < 3; ++i) {
    const Vec3 &a = in[i], &b = in[(i + 1) % 3];
    const double da = a.z - near_distance, db = b.z - near_distance;
    if (da >= 0.0) out[count++] = a;
    if ((da >= 0.0) != (db >= 0.0)) out[count++] = a + (da / (da - db)) * (b - a);
  }
  return count;
}

}  // namespace

CameraFrame::CameraFrame(const RasterCamera& camera, double aspect) : eye(camera.eye) {
  forward = normalized(camera.target - camera.eye);
  Vec3 side = cross(forward, camera.up);
  if (squared_norm(side) < 1e-12) side = cross(forward, Vec3{0.0, 1.0, 0.0});
  if (squared_norm(side) < 1e-12) side = cross(forward, Vec3{1.0, 0.0, 0.0});
  right = normalized(side);
  up = cross(right, forward);
  half_height = std::tan(0.5 * camera.vertical_fov);
  half_width = half_height * aspect;
}

VisibilityBuffer draw_visibility(const TriangleScene& scene, const CameraFrame& frame, int width, int height,
                                 double near_distance, ThreadPool& pool) {
  std::vector<ScreenTriangle> screen;
  screen.reserve(scene.triangles.size());
  for (size_t t = 0; t < scene.triangles.size(); ++t) {
    std::array<Vec3, 3> view;
    for (int i = 0; i < 3; ++i) {
      const Vec3 d = scene.triangles[t].corners[i] - frame.eye;
      view[i] = {dot(d, frame.right), dot(d, frame.up), dot(d, frame.forward)};
    }
    std::array<Vec3, 4> clipped;
    const int count = clip_near(view, near_distance, clipped);
    std::array<ScreenPoint, 4> p;
    for (int i = 0; i < count; ++i) {
      const Vec3& v = clipped[i];
      p[i] = {0.5 * width * (1.0 + v.x / (v.z * frame.half_width)),
              0.5 * height * (1.0 - v.y / (v.z * frame.half_height)), 1.0 / v.z};
    }
    for (int i = 2; i < count; ++i) screen.push_back({{p[0], p[i - 1], p[i]}, static_cast<int32_t>(t)});
  }
  VisibilityBuffer buffer{width, height, {}, {}};
  const size_t samples = static_cast<size_t>(width) * height;
  buffer.inverse_depth.assign(samples, 0.0f);
  buffer.triangle.assign(samples, -1);
  constexpr int kBandRows = 64;
  pool.for_each_range(height, kBandRows, [&](int64_t begin, int64_t end) {
    for (const ScreenTriangle& triangle : screen)
      scan(triangle.p, width, static_cast<int>(begin), static_cast<int>(end), [&](int x, int y, double w) {
        const size_t i = static_cast<size_t>(y) * width + x;
        if (static_cast<float>(w) <= buffer.inverse_depth[i]) return;
        buffer.inverse_depth[i] = static_cast<float>(w);
        buffer.triangle[i] = triangle.id;
      });
  });
  return buffer;
}

ShadowMap::ShadowMap(const Vec3& towards_light, const Vec3& center, double reach, int resolution,
                     double spread)
    : towards_light_(towards_light),
      center_(center),
      reach_(reach),
      spread_(spread),
      resolution_(resolution) {
  const Vec3 other = std::fabs(towards_light.z) < 0.9 ? Vec3{0.0, 0.0, 1.0} : Vec3{0.0, 1.0, 0.0};
  right_ = normalized(cross(other, towards_light));
  up_ = cross(towards_light, right_);
  depth_.assign(static_cast<size_t>(resolution) * resolution, std::numeric_limits<float>::infinity());
}

void ShadowMap::draw(std::span<const Triangle> triangles) {
  const double scale = 0.5 * resolution_ / reach_;
  for (const Triangle& triangle : triangles) {
    std::array<ScreenPoint, 3> p;
    for (int i = 0; i < 3; ++i) {
      const Vec3 d = triangle.corners[i] - center_;
      p[i] = {(dot(d, right_) + reach_) * scale, (dot(d, up_) + reach_) * scale, -dot(d, towards_light_)};
    }
    scan(p, resolution_, 0, resolution_, [&](int x, int y, double w) {
      float& depth = depth_[static_cast<size_t>(y) * resolution_ + x];
      depth = std::min(depth, static_cast<float>(w));
    });
  }
  if (spread_ > 0.0) find_nearest();
}

void ShadowMap::find_nearest() {
  const int tiles = (resolution_ + kTile - 1) / kTile;
  const auto at = [&](int i, int j) { return static_cast<size_t>(j) * tiles + i; };
  std::vector<float> own(static_cast<size_t>(tiles) * tiles, std::numeric_limits<float>::infinity());
  for (int y = 0; y < resolution_; ++y)
    for (int x = 0; x < resolution_; ++x) {
      float& nearest = own[at(x / kTile, y / kTile)];
      nearest = std::min(nearest, depth_[static_cast<size_t>(y) * resolution_ + x]);
    }
  nearest_ = own;
  for (int j = 0; j < tiles; ++j)
    for (int i = 0; i < tiles; ++i)
      for (int y = std::max(0, j - 1); y <= std::min(tiles - 1, j + 1); ++y)
        for (int x = std::max(0, i - 1); x <= std::min(tiles - 1, i + 1); ++x)
          nearest_[at(i, j)] = std::min(nearest_[at(i, j)], own[at(x, y)]);
}

float ShadowMap::nearest_around(const Place& place) const {
  const int tiles = (resolution_ + kTile - 1) / kTile;
  return nearest_[static_cast<size_t>(place.y) / kTile * tiles + static_cast<size_t>(place.x) / kTile];
}

ShadowMap::Place ShadowMap::place_of(const Vec3& point, const Vec3& normal) const {
  // Lifting by the texel over which the surface is sampled removes the stripes of self-shadowing; the steeper
  // the light, the less is needed.
  const double cosine = std::max(kSteepest, dot(normal, towards_light_));
  const double lift = texel() * std::min(2.0, std::sqrt(1.0 - std::min(1.0, cosine * cosine)) / cosine);
  const Vec3 d = point + (1.3 * texel()) * normal - center_;
  return {.x = (dot(d, right_) + reach_) / texel() - 0.5,
          .y = (dot(d, up_) + reach_) / texel() - 0.5,
          .depth = -dot(d, towards_light_) - 0.6 * lift,
          .slope = {dot(normal, right_) / cosine * texel(), dot(normal, up_) / cosine * texel()}};
}

bool ShadowMap::is_inside(const Place& place) const {
  return place.x >= 0.0 && place.y >= 0.0 && place.x < resolution_ - 1.0 && place.y < resolution_ - 1.0;
}

double ShadowMap::visibility(const Vec3& point, const Vec3& normal) const {
  const Place place = place_of(point, normal);
  if (!is_inside(place)) return 1.0;
  const bool is_soft = spread_ > 0.0 && dot(normal, towards_light_) > kSteepest;
  return is_soft ? blurred(place) : sharp(place);
}

double ShadowMap::sharp(const Place& place) const {
  const double fx = std::floor(place.x), fy = std::floor(place.y), z = place.depth;
  const float* row = &depth_[static_cast<size_t>(fy) * resolution_ + static_cast<size_t>(fx)];
  const double a = z <= row[0], b = z <= row[1], c = z <= row[resolution_], e = z <= row[resolution_ + 1];
  const double tx = place.x - fx, ty = place.y - fy;
  return (a * (1.0 - tx) + b * tx) * (1.0 - ty) + (c * (1.0 - tx) + e * tx) * ty;
}

// Percentage-closer soft shadows [Fernando 2005]: what is in the way, then how much of the light is seen past
// it.
double ShadowMap::blurred(const Place& place) const {
  // Around the place the surface itself is nearer to the light, by as much as it is slanted. What rises less
  // above it casts a sharp shadow.
  const double own = kReach * (std::fabs(place.slope[0]) + std::fabs(place.slope[1]));
  const float nearest = nearest_around(place);
  if (place.depth - nearest <= own) return sharp(place);
  const Blockers around = look(place, penumbra(place, nearest), kFewSamples);
  if (around.share == 0.0) return 1.0;
  const double radius = penumbra(place, around.depth);
  return radius < kSharp ? sharp(place) : 1.0 - look(place, radius, kSamples).share;
}

double ShadowMap::penumbra(const Place& place, double depth) const {
  return std::min(spread_ * (place.depth - depth) / texel(), static_cast<double>(kTile));
}

ShadowMap::Blockers ShadowMap::look(const Place& place, double radius,
                                    std::span<const std::array<double, 2>> samples) const {
  int blocked = 0;
  double depths = 0.0;
  for (const auto& [along_x, along_y] : samples) {
    const double dx = radius * along_x, dy = radius * along_y;
    const auto x = static_cast<int>(place.x + dx + 0.5), y = static_cast<int>(place.y + dy + 0.5);
    if (x < 0 || y < 0 || x >= resolution_ || y >= resolution_) continue;
    const float depth = depth_[static_cast<size_t>(y) * resolution_ + x];
    if (place.depth + place.slope[0] * dx + place.slope[1] * dy <= depth) continue;
    ++blocked;
    depths += depth;
  }
  if (blocked == 0) return {};
  return {.share = static_cast<double>(blocked) / static_cast<double>(samples.size()),
          .depth = depths / blocked};
}

}  // namespace stark::raster
