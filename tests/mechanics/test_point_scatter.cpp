// Dynamic elements of points on several threads: bit for bit the sums of one thread.
#include <doctest/doctest.h>

#include <algorithm>
#include <cstring>

#include <stark/mechanics/point_scatter.h>
#include <support/solid_bench.h>

using namespace stark;
using namespace stark::test;

namespace {

const ParameterValues kValues{{"shear_modulus", {{2.0}, false}}, {"bulk_modulus", {{3.0}, false}}};

PotentialBatch tetrahedra(const TetMesh& mesh) {
  PotentialBatch batch(std::make_shared<Potential>(tet4(test_law()), symbolic::Backend::Automatic));
  batch.resize(SolidMesh(mesh).elements);
  batch.set_rest(mesh.vertices);
  set_values(batch, kValues);
  return batch;
}

template <typename T>
bool same_bits(const T& a, const T& b) {
  return a.size() == b.size() && std::memcmp(a.data(), b.data(), a.size() * sizeof(double)) == 0;
}

}  // namespace

TEST_CASE("elements of points add up to the same bits on any number of threads") {
  const TetMesh mesh = make_tet_box({1, 1, 1}, {6, 6, 6});
  PotentialBatch batch = tetrahedra(mesh);
  REQUIRE(batch.size() > 1024);
  batch.set_resting([](int64_t e) { return e / 64 % 3 == 1; });
  std::vector<Vec3> x = mesh.vertices;
  RandomPoints random(3);
  for (Vec3& p : x) p += random.point() * 0.05;
  const KinematicMap map = point_map(x.size(), {0, 5, 40});
  std::vector<double> gradient_1;
  AlignedVector<double> values_1;
  for (const int threads : {1, 2, 3, 5}) {
    ThreadPool pool(threads);
    CHECK(PointScatter().take(batch, map, pool) == (threads > 1));
    Assembler assembler(map, pool);
    assembler.set_dynamic_batches({&batch});
    std::vector<double> gradient(3 * map.layout().block_count);
    BlockMatrix hessian;
    assembler.assemble({}, x, {}, gradient, hessian);
    if (threads == 1) gradient_1 = gradient, values_1 = hessian.values;
    CHECK(same_bits(gradient, gradient_1));
    CHECK(same_bits(hessian.values, values_1));
  }
  CHECK(std::ranges::any_of(values_1, [](double value) { return value != 0.0; }));
}

TEST_CASE("other sites than points, and few elements, are left to one thread") {
  const TetMesh mesh = make_tet_box({1, 1, 1}, {6, 6, 6});
  const PotentialBatch batch = tetrahedra(mesh);
  ThreadPool pool(2);
  std::vector<Site> sites;
  for (int32_t i = 0; i < std::ssize(mesh.vertices); ++i)
    sites.push_back({.kind = SiteKind::Point, .index = i, .local = {}, .points = {}, .weights = {}});
  sites.back() = {.kind = SiteKind::RigidPoint, .index = 0, .local = {1, 0, 0}, .points = {}, .weights = {}};
  const KinematicMap mixed(DofLayout::build(std::vector<bool>(sites.size(), false), {false}), sites);
  CHECK(!PointScatter().take(batch, mixed, pool));
  const TetMesh small = make_tet_box({1, 1, 1}, {2, 2, 2});
  CHECK(!PointScatter().take(tetrahedra(small), point_map(small.vertices.size()), pool));
}
