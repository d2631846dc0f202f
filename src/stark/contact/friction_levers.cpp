#include <stark/contact/friction_levers.h>

#include <algorithm>
#include <cmath>
#include <utility>

#include <stark/base/smooth_step.h>

namespace stark {

namespace {

Vec3 normal_of(const Index3& t, std::span<const Vec3> x) {
  return normalized(cross(x[t[1]] - x[t[0]], x[t[2]] - x[t[0]]));
}

/// Cosines of 11 and 6 degrees between the normals of two faces: from the second on one lies on the other.
constexpr double kTilted = 0.98, kLevel = 0.995;

/// Cosines of 60 and 37 degrees between the gap and the normal of a face: what touches beside the border of
/// the face has friction there.
constexpr double kBeside = 0.5, kFacing = 0.8;
/// Such faces and those that lie on them turn no more away from the gap.
constexpr double kUpright = 0.3;

/// Part of the smaller of two faces from which on what they share carries friction.
constexpr double kShared = 0.5;

/// Shares of the corners of a triangle in a point above it, which add up to one.
std::array<double, 3> barycentric(const Index3& t, const Vec3& point, std::span<const Vec3> x) {
  const Vec3 u = x[t[1]] - x[t[0]], v = x[t[2]] - x[t[0]], area = cross(u, v), d = point - x[t[0]];
  const double b = dot(cross(d, v), area) / squared_norm(area),
               c = dot(cross(u, d), area) / squared_norm(area);
  return {1.0 - b - c, b, c};
}

/// The point of the plane of a triangle below or above another one.
Vec3 in_plane(const Index3& t, const Vec3& point, std::span<const Vec3> x) {
  const auto shares = barycentric(t, point, x);
  return x[t[0]] * shares[0] + x[t[1]] * shares[1] + x[t[2]] * shares[2];
}

/// Part of the depth of the vertex in its contact distance from which the site carries all of its share.
constexpr double kCarries = 0.5;

}  // namespace

void LeverArms::append(const PairKey& key, const LeverArm& arm) { arms_.push_back({key, arm}); }

std::optional<LeverArm> LeverArms::find(const PairKey& key, std::span<const int32_t> patch) const {
  const auto own = std::ranges::lower_bound(arms_, key, {}, &Entry::key);
  if (own != arms_.end() && own->key == key) return own->arm;
  if (key.kind != PairKind::PointTriangle || patch.empty()) return {};
  for (auto entry = std::ranges::lower_bound(arms_, PairKey{key.kind, key.first, 0}, {}, &Entry::key);
       entry != arms_.end() && entry->key.kind == key.kind && entry->key.first == key.first; ++entry)
    if (patch[entry->key.second] == patch[key.second]) return entry->arm;
  return {};
}

FrictionLevers::FrictionLevers(const SurfaceMesh& mesh, std::vector<LeverSite> sites,
                               std::vector<int32_t> patch)
    : sites_(std::move(sites)), patch_(std::move(patch)) {
  if (sites_.empty()) return;
  std::ranges::sort(sites_, {}, [](const LeverSite& s) { return std::pair(s.vertex, s.triangle); });
  borders_ = SurfaceCells(mesh, patch_);
  std::map<int32_t, int32_t> known;  // by triangle
  for (const LeverSite& s : sites_) {
    const auto [face, is_new] = known.try_emplace(s.triangle, static_cast<int32_t>(faces_.size()));
    if (is_new) faces_.push_back({s.triangle, {}});
    faces_[face->second].corners.push_back(s.vertex);
    face_of_.push_back(face->second);
  }
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

template <class Visit>
void FrictionLevers::visit_faces(const SurfaceMesh& mesh, std::span<const int32_t> vertices, const Vec3& gap,
                                 std::span<const Vec3> x, const Visit& visit) const {
  for (auto s = std::ranges::lower_bound(sites_, vertices[0], {}, &LeverSite::vertex);
       s != sites_.end() && s->vertex == vertices[0]; ++s) {
    const Face& face = faces_[face_of_[s - sites_.begin()]];
    const auto is_corner = [&](int32_t v) { return std::ranges::count(face.corners, v) > 0; };
    if (!std::ranges::all_of(vertices.subspan(1), is_corner)) continue;
    const Vec3 normal = normal_of(mesh.triangles[face.triangle], x);
    if (std::fabs(dot(normal, gap)) > kUpright) visit(face, normal);
  }
}

FrictionLevers::Flat FrictionLevers::flattest_pair(const SurfaceMesh& mesh, std::span<const int32_t> of_a,
                                                   std::span<const int32_t> of_b, const Vec3& gap,
                                                   std::span<const Vec3> x) const {
  Flat best;
  visit_faces(mesh, of_a, gap, x, [&](const Face& a, const Vec3& normal_a) {
    visit_faces(mesh, of_b, gap, x, [&](const Face& b, const Vec3& normal_b) {
      const double level = std::fabs(dot(normal_a, normal_b)), facing = std::fabs(dot(normal_b, gap));
      const double part = smooth_step((level - kTilted) / (kLevel - kTilted)) *
                          smooth_step((facing - kBeside) / (kFacing - kBeside));
      if (part > best.part) best = {{&a, &b}, part};
    });
  });
  return best;
}

// The corners of what both faces share carry all of the pressure, wherever they are on the faces. So friction
// acts as far inside of it as the pressure does that they stand for, and where faces tilt at the corners.
std::optional<SharedPlace> FrictionLevers::shared_place(const SurfaceMesh& mesh, const Contact& contact,
                                                        std::span<const Vec3> x, PressedAreas& areas) const {
  const auto sites = std::span(contact.sites);
  const auto count = static_cast<size_t>(contact.side_a_count);
  const auto of_a = sites.first(count), of_b = sites.subspan(count, contact.point_count - count);
  const Vec3 gap = gap_vector(contact, x);
  const Flat flat = flattest_pair(mesh, of_a, of_b, normalized(gap), x);
  if (flat.part == 0.0) return {};
  const auto corners_of = [&](const Face& face) {
    std::vector<Vec3> corners;
    for (const int32_t v : face.corners) corners.push_back(x[v]);
    return corners;
  };
  const Index2 triangles{flat.faces[0]->triangle, flat.faces[1]->triangle};
  const Index3 &face = mesh.triangles[triangles[0]], &carrier = mesh.triangles[triangles[1]];
  const Vec3 outwards = normal_of(carrier, x), normal = outwards * (dot(gap, outwards) > 0.0 ? 1.0 : -1.0);
  const auto [known, is_new] = areas.try_emplace(triangles);
  std::optional<PressedArea>& area = known->second;
  if (is_new) area = find_pressed_area(corners_of(*flat.faces[0]), corners_of(*flat.faces[1]), normal);
  if (!area || area->of_smaller < kShared) return {};
  if (area->is_inside && contact.key.kind == PairKind::PointTriangle) return {};
  Vec3 point;
  for (size_t k = 0; k < count; ++k) point += x[of_a[k]] * contact.weights[k];
  const Vec3 place = in_plane(face, point + (area->centre - point) * (1.0 - area->part), x);
  const double depth = contact.contact_distance - norm(gap), farther = dot(place - point, normal);
  const double part = flat.part * smooth_step((depth - farther) / (kCarries * depth));
  if (!(depth > 0.0 && part > 0.0)) return {};
  return SharedPlace{face, barycentric(face, point + (place - point) * part, x), carrier};
}

}  // namespace stark
