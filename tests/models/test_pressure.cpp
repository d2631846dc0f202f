// Pressure: energy -p V of a closed surface, forces of p times area, whatever the origin.
#include <doctest/doctest.h>

#include <array>

#include <support/model_checks.h>

using namespace stark;
using namespace stark::test;

namespace {

/// Outward faces of the tetrahedron of the origin and the three unit vectors, moved by `shift`.
std::vector<std::array<Vec3, 3>> faces(const Vec3& shift) {
  const Vec3 p[4] = {shift, shift + Vec3{1, 0, 0}, shift + Vec3{0, 1, 0}, shift + Vec3{0, 0, 1}};
  return {{p[1], p[2], p[3]}, {p[0], p[2], p[1]}, {p[0], p[3], p[2]}, {p[0], p[1], p[3]}};
}

FilledSample inputs(double pressure, const Vec3& origin) {
  FilledSample sample = element({{}, {}, {}}, {{}, {}, {}}, {{"pressure", pressure}});
  sample.values["origin"] = {origin.x, origin.y, origin.z};
  return sample;
}

}  // namespace

TEST_CASE("the energy of a closed surface is -p V for every origin and place") {
  const Potential potential = compiled(models::pressure());
  for (const Vec3& shift : {Vec3{}, Vec3{3, -2, 5}})
    for (const Vec3& origin : {Vec3{}, Vec3{-1, 4, 2}}) {
      double total = 0.0;
      for (const auto& face : faces(shift))
        total += energy(potential, inputs(12.0, origin), {face[0], face[1], face[2]});
      CHECK(total == doctest::Approx(-12.0 / 6.0).epsilon(1e-13));
    }
}

TEST_CASE("the force on a triangle of a closed surface is p times its area vector") {
  // All forces on the tetrahedron: on every vertex a third of the area vectors of its three faces.
  const Potential potential = compiled(models::pressure());
  const Vec3 origin{0.3, -0.1, 0.2};
  const auto surface = faces({});
  Vec3 on_apex;  // the vertex (0, 0, 1), which is in faces 0, 2 and 3
  for (const auto& face : surface) {
    const std::vector<double> g = gradient(potential, inputs(6.0, origin), {face[0], face[1], face[2]});
    for (int i = 0; i < 3; ++i)
      if (face[i].z == 1.0) on_apex += Vec3{-g[3 * i], -g[3 * i + 1], -g[3 * i + 2]};
  }
  // Area vectors (1, 1, 1)/2, (-1, 0, 0)/2, (0, -1, 0)/2 sum to (0, 0, 1)/2; times p/3.
  CHECK(on_apex.x == doctest::Approx(0.0).epsilon(1e-14));
  CHECK(on_apex.y == doctest::Approx(0.0).epsilon(1e-14));
  CHECK(on_apex.z == doctest::Approx(1.0));
}
