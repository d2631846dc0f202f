#include <stark/contact/friction_memory.h>

#include <algorithm>
#include <cmath>

namespace stark {

namespace {

constexpr int kPrimitiveBits = 30;

/// Sine of the angle to the normal below which a material direction says little of the tangent plane.
constexpr double kSmallestSine = 0.1;

Vec3 material_direction(const SurfaceMesh& mesh, const PairKey& key, std::span<const Vec3> x, int choice) {
  const auto along = [&](const auto& primitive) {
    const size_t n = primitive.size();
    return x[primitive[(choice + 1) % n]] - x[primitive[choice % n]];
  };
  if (key.kind == PairKind::PointTriangle) return along(mesh.triangles[key.second]);
  if (key.kind == PairKind::EdgeEdge)
    return along(choice == 0 ? mesh.edges[key.first] : mesh.edges[key.second]);
  if (key.kind == PairKind::PointEdge) return along(mesh.edges[key.second]);
  return {};
}

}  // namespace

int64_t pack(const PairKey& key) {
  return (static_cast<int64_t>(key.kind) << (2 * kPrimitiveBits)) |
         (static_cast<int64_t>(key.first) << kPrimitiveBits) | static_cast<int64_t>(key.second);
}

PairKey unpack(int64_t code) {
  constexpr int64_t kMask = (int64_t{1} << kPrimitiveBits) - 1;
  return {static_cast<PairKind>(code >> (2 * kPrimitiveBits)),
          static_cast<int32_t>((code >> kPrimitiveBits) & kMask), static_cast<int32_t>(code & kMask)};
}

void FrictionMemory::reserve(size_t count) {
  pair.reserve(count);
  deflection.reserve(count);
  force.reserve(count);
}

void FrictionMemory::append(const PairKey& key, const Vec3& pair_deflection, double normal_force) {
  pair.push_back(pack(key));
  deflection.push_back(pair_deflection);
  force.push_back(normal_force);
}

int64_t FrictionMemory::find(const PairKey& key) const {
  const int64_t code = pack(key);
  const auto found = std::lower_bound(pair.begin(), pair.end(), code);
  return found != pair.end() && *found == code ? found - pair.begin() : -1;
}

std::pair<int64_t, int64_t> FrictionMemory::of_first(const PairKey& key) const {
  const auto at = [&](int32_t first) {
    return std::ranges::lower_bound(pair, pack({key.kind, first, 0})) - pair.begin();
  };
  return {at(key.first), at(key.first + 1)};
}

double spin(const SurfaceMesh& mesh, const PairKey& key, const Vec3& normal, std::span<const Vec3> x0,
            std::span<const Vec3> x1) {
  const auto tangential = [&](const Vec3& v) { return v - normal * dot(normal, v); };
  for (int choice = 0; choice < 2; ++choice) {
    const Vec3 before = material_direction(mesh, key, x0, choice);
    const Vec3 from = tangential(before), to = tangential(material_direction(mesh, key, x1, choice));
    if (norm(from) > kSmallestSine * norm(before))
      return std::atan2(dot(normal, cross(from, to)), dot(from, to));
  }
  return 0.0;
}

double orientation(const SurfaceMesh& mesh, const Contact& contact) {
  if (contact.key.kind != PairKind::EdgeEdge) return 1.0;
  const Index2& edge = mesh.edges[contact.key.first];
  return contact.sites[0] == edge[0] || contact.sites[0] == edge[1] ? 1.0 : -1.0;
}

}  // namespace stark
