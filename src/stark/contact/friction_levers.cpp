#include <stark/contact/friction_levers.h>

#include <algorithm>
#include <cmath>
#include <utility>

namespace stark {

namespace {

Vec3 normal_of(const Index3& t, std::span<const Vec3> x) {
  return normalized(cross(x[t[1]] - x[t[0]], x[t[2]] - x[t[0]]));
}

/// Cosines of 11 and 6 degrees between the normals of two faces: from the second on one lies on the other.
constexpr double kTilted = 0.98, kLevel = 0.995;

/// Part of the depth of the vertex in its contact distance from which the site carries all of its share.
constexpr double kCarries = 0.5;

double smooth_step(double t) {
  t = std::clamp(t, 0.0, 1.0);
  return t * t * (3.0 - 2.0 * t);
}

}  // namespace

FrictionLevers::FrictionLevers(const SurfaceMesh& mesh, std::vector<LeverSite> sites,
                               std::vector<int32_t> patch)
    : sites_(std::move(sites)), patch_(std::move(patch)) {
  if (sites_.empty()) return;
  std::ranges::sort(sites_, {}, [](const LeverSite& s) { return std::pair(s.vertex, s.triangle); });
  borders_ = SurfaceCells(mesh, patch_);
}

LeverArm FrictionLevers::flattest(const SurfaceMesh& mesh, int32_t vertex, const Vec3& normal,
                                  std::span<const Vec3> x) const {
  LeverArm best;
  double most = kTilted;
  for (auto s = std::ranges::lower_bound(sites_, vertex, {}, &LeverSite::vertex);
       s != sites_.end() && s->vertex == vertex; ++s) {
    const double cosine = std::fabs(dot(normal_of(mesh.triangles[s->triangle], x), normal));
    if (cosine <= most) continue;
    most = cosine;
    best = {s->site, smooth_step((cosine - kTilted) / (kLevel - kTilted))};
  }
  return best;
}

// Crossings of the line with the border: those beyond the site tell whether that is inside, the first one on
// the way where the face ends.
double FrictionLevers::part_within(int32_t triangle, const Vec3& normal, const Vec3& from, const Vec3& to,
                                   std::span<const Vec3> x) const {
  const Vec3 way = to - from, flat = way - normal * dot(normal, way);
  const double length = norm(flat);
  if (!(length > 0.0)) return 0.0;
  const Vec3 along = flat / length, across = cross(normal, along);
  bool is_inside = false, starts_inside = false;
  double first = length;  // from the vertex [m]
  for (const Index2& edge : borders_.edges(patch_.empty() ? triangle : patch_[triangle])) {
    const Vec3 a = x[edge[0]] - from, b = x[edge[1]] - from;
    const double height_a = dot(a, across), height_b = dot(b, across);
    if ((height_a > 0.0) == (height_b > 0.0)) continue;
    const double at = dot(a + (b - a) * (height_a / (height_a - height_b)), along);
    if (at > 0.0) starts_inside = !starts_inside;
    if (at > length)
      is_inside = !is_inside;
    else if (at > 0.0)
      first = std::min(first, at);
  }
  if (is_inside) return 1.0;
  return starts_inside ? first / length : 0.0;
}

LeverArm FrictionLevers::arm(const SurfaceMesh& mesh, const Contact& contact, int32_t triangle,
                             const Vec3& normal, std::span<const Vec3> x) const {
  const Vec3& vertex = x[contact.sites[0]];
  LeverArm arm = flattest(mesh, contact.sites[0], normal, x);
  // A contact that has slid around an edge may be named by the face before.
  if (arm.part == 0.0 || std::fabs(dot(normal_of(mesh.triangles[triangle], x), normal)) < kTilted) return {};
  // The site presses, too, as far as it is within the contact distance: of an even pressure, as much.
  const Vec3& place = x[arm.site];
  const Vec3 gap = gap_vector(contact, x);
  const double farther = dot(place - vertex, normal) * (dot(gap, normal) > 0.0 ? 1.0 : -1.0);
  const double depth = contact.contact_distance - norm(gap);
  arm.part *= smooth_step((depth - farther) / (kCarries * depth));
  if (!(arm.part > 0.0)) return {};
  arm.part *= part_within(triangle, normal, vertex, place, x);
  return arm;
}

}  // namespace stark
