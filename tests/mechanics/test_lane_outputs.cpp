// Outputs of all elements on several threads against those on one.
#include <doctest/doctest.h>

#include <algorithm>

#include <stark/mechanics/lane_outputs.h>
#include <support/solid_bench.h>

using namespace stark;
using namespace stark::test;
using symbolic::Order;

namespace {

const ParameterValues kValues{{"shear_modulus", {{2.0}, false}}, {"bulk_modulus", {{3.0}, false}}};

template <typename Batch>
void check_threads(const Batch& batch, std::vector<Vec3> x) {
  RandomPoints random(5);
  for (Vec3& p : x) p += random.point() * 0.02;
  ThreadPool pool(3);
  for (const Order order : {Order::Energy, Order::Gradient}) {
    const AlignedVector<double> alone = lane_outputs(batch, order, x, nullptr);
    CHECK(std::ranges::any_of(alone, [](double value) { return value != 0.0; }));
    CHECK(std::ranges::equal(alone, lane_outputs(batch, order, x, &pool)));
  }
}

}  // namespace

TEST_CASE("outputs of all elements are the same on several threads") {
  const TetMesh tets = make_tet_box({1, 1, 1}, {6, 6, 6});
  PotentialBatch linear(std::make_shared<Potential>(tet4(test_law()), symbolic::Backend::Automatic));
  linear.resize(SolidMesh(tets).elements);
  linear.set_rest(tets.vertices);
  set_values(linear, kValues);
  check_threads(linear, tets.vertices);
  for (const SolidMesh& mesh : distorted_boxes({6, 5, 5}, 0.0))
    check_threads(make_quadrature_batch(mesh, quadrature_point(test_law()), kValues), mesh.vertices);
}
