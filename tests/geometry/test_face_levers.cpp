// Places of corners' shares in flat faces.
#include <doctest/doctest.h>

#include <cmath>

#include <stark/geometry/face_levers.h>
#include <stark/geometry/shapes.h>

using namespace stark;

TEST_CASE("corners of a square have the mean distance of its points from the centre") {
  const TriangleMesh box = make_box({2.0, 2.0, 2.0});
  const std::vector<FaceLever> levers = find_face_levers(box.vertices, box.triangles);
  CHECK(levers.size() == 24);
  const double mean = (std::sqrt(2.0) + std::asinh(1.0)) / 3.0;  // of a square of side 2
  for (const FaceLever& lever : levers) {
    const Vec3& corner = box.vertices[lever.vertex];
    int in_face = 0;
    double squared = 0.0;
    for (int k = 0; k < 3; ++k) {
      const bool is_of_face = std::fabs(lever.place[k] - corner[k]) < 1e-12;
      in_face += is_of_face;
      if (!is_of_face) squared += lever.place[k] * lever.place[k];
    }
    CHECK(in_face == 1);
    CHECK(std::sqrt(squared) == doctest::Approx(mean).epsilon(0.005));
    const Index3& t = box.triangles[lever.triangle];
    const Vec3 n =
        normalized(cross(box.vertices[t[1]] - box.vertices[t[0]], box.vertices[t[2]] - box.vertices[t[0]]));
    CHECK(std::fabs(dot(n, lever.place - box.vertices[t[0]])) < 1e-12);
  }
}

TEST_CASE("faces with many vertices inside and small ones have none") {
  const TriangleMesh fine = make_box({1.0, 1.0, 1.0}, 4);
  CHECK(find_face_levers(fine.vertices, fine.triangles).empty());
  const TriangleMesh ball = make_icosphere(1.0, 2);
  CHECK(find_face_levers(ball.vertices, ball.triangles).empty());
}

static std::vector<int32_t> find_lone(const TriangleMesh& mesh) {
  return find_lone_vertices(mesh.vertices, mesh.triangles, find_flat_faces(mesh.vertices, mesh.triangles));
}

TEST_CASE("a few vertices inside a face are left out, and its border has the lever arms") {
  const TriangleMesh coarse = make_box({1.0, 1.0, 1.0}, 2), plain = make_box({1.0, 1.0, 1.0});
  CHECK(find_lone(coarse).size() == 6);
  CHECK(find_face_levers(coarse.vertices, coarse.triangles).size() == 48);
  CHECK(find_lone(plain).empty());
  const TriangleMesh fine = make_box({1.0, 1.0, 1.0}, 4);
  CHECK(find_lone(fine).empty());
}
