// Assembly of elements with quadrature points: derivatives against differences, invariance, definiteness,
// prescribed nodes, patch test, the same bits on any number of threads.
#include <doctest/doctest.h>

#include <cmath>

#include <stark/base/rotation.h>
#include <support/finite_differences.h>
#include <support/solid_bench.h>
#include <support/symmetric_eigen.h>

using namespace stark;
using namespace stark::test;

namespace {

const ParameterValues kValues{{"shear_modulus", {{2.0}, false}}, {"bulk_modulus", {{3.0}, false}}};

struct Bench {
  Bench(const SolidMesh& m, const std::vector<int32_t>& prescribed = {}, int threads = 1)
      : mesh(m),
        batch(make_quadrature_batch(m, quadrature_point(test_law()), kValues)),
        map(point_map(m.vertices.size(), prescribed)),
        pool(threads),
        assembler(map, pool) {
    assembler.set_static_batches({}, {&batch});
  }
  DenseSystem at(const std::vector<Vec3>& x, const AssemblyOptions& options = {}) {
    return assemble_dense(assembler, map, x, options);
  }
  SolidMesh mesh;
  QuadratureBatch batch;
  KinematicMap map;
  ThreadPool pool;
  Assembler assembler;
};

std::vector<Vec3> shaken(const std::vector<Vec3>& X, double size, unsigned seed = 5) {
  RandomPoints random(seed);
  std::vector<Vec3> x = X;
  for (Vec3& p : x) p += random.point() * size;
  return x;
}

/// One element of each type.
std::vector<SolidMesh> single_elements() {
  std::vector<SolidMesh> meshes = distorted_boxes({1, 1, 1});
  for (SolidMesh& mesh : meshes)  // the first element alone; other vertices stay without one
    mesh.elements.resize(mesh.node_count());
  return meshes;
}

double largest(const std::vector<double>& values) {
  double result = 0.0;
  for (const double v : values) result = std::fmax(result, std::fabs(v));
  return result;
}

}  // namespace

TEST_CASE("gradient and Hessian agree with differences of energy and gradient") {
  for (const SolidMesh& mesh : single_elements()) {
    Bench bench(mesh);
    const std::vector<Vec3> x = shaken(mesh.vertices, 0.05);
    const DenseSystem exact = bench.at(x);
    const size_t n = exact.gradient.size();
    const auto moved = [&](size_t i, double t) {
      std::vector<Vec3> y = x;
      y[i / 3][static_cast<int>(i % 3)] += t;
      return y;
    };
    for (size_t i = 0; i < n; ++i) {
      const double slope = differentiate_scalar(
          [&](double t) { return bench.assembler.static_energy_difference(moved(i, t)).difference; }, 0.02);
      CHECK(std::fabs(slope - exact.gradient[i]) < 1e-8);
      const std::vector<double> row =
          differentiate([&](double t) { return bench.at(moved(i, t)).gradient; }, 0.02);
      for (size_t j = 0; j < n; ++j) CHECK(std::fabs(row[j] - exact.hessian[i * n + j]) < 1e-7);
      bench.at(x);  // the energies of reference for the next differences
    }
  }
}

TEST_CASE("rigid motion changes no energy, turns the forces, and leaves neither force nor torque") {
  const Mat3 R = exp_rotation({0.5, -1.2, 0.8});
  for (const SolidMesh& mesh : distorted_boxes()) {
    Bench bench(mesh);
    const std::vector<Vec3> x = shaken(mesh.vertices, 0.05);
    std::vector<Vec3> turned;
    for (const Vec3& p : x) turned.push_back(R * p + Vec3{1, 2, 3});
    const DenseSystem plain = bench.at(x);
    CHECK(std::fabs(bench.assembler.static_energy_difference(turned).difference) < 1e-13);
    const DenseSystem moved = bench.at(turned);
    Vec3 force, torque;
    for (size_t p = 0; p < x.size(); ++p) {
      const Vec3 f{plain.gradient[3 * p], plain.gradient[3 * p + 1], plain.gradient[3 * p + 2]};
      const Vec3 g{moved.gradient[3 * p], moved.gradient[3 * p + 1], moved.gradient[3 * p + 2]};
      CHECK(max_abs(R * f - g) < 1e-12);
      force += f;
      torque += cross(x[p], f);
    }
    CHECK(norm(force) < 1e-13);
    CHECK(norm(torque) < 1e-13);
  }
}

TEST_CASE("patch test: affine positions on the boundary carry no forces inside") {
  const Mat3 F = exp_rotation({0.2, 0.1, -0.3}) * Mat3::diagonal({1.2, 0.85, 1.05});
  for (const SolidMesh& mesh : distorted_boxes({2, 2, 2})) {
    std::vector<bool> on_boundary(mesh.vertices.size(), false);
    for (const Index3& t : find_boundary_triangles(mesh))
      for (const int32_t v : t) on_boundary[v] = true;
    Bench bench(mesh);
    std::vector<Vec3> x;
    for (const Vec3& X : mesh.vertices) x.push_back(F * X);
    const DenseSystem system = bench.at(x);
    int inside = 0;
    for (size_t p = 0; p < x.size(); ++p)
      if (!on_boundary[p]) {
        ++inside;
        for (int c = 0; c < 3; ++c) CHECK(std::fabs(system.gradient[3 * p + c]) < 1e-14);
      }
    CHECK(inside > 0);
    CHECK(largest(system.gradient) > 1e-2);  // the boundary does carry forces
  }
}

TEST_CASE("projected Hessians are positive semidefinite, and the same where nothing is to project") {
  for (const SolidMesh& mesh : single_elements()) {
    Bench bench(mesh);
    std::vector<Vec3> squeezed;
    for (const Vec3& X : mesh.vertices) squeezed.push_back(Mat3::diagonal({0.6, 0.7, 1.0}) * X);
    const int n = static_cast<int>(3 * mesh.vertices.size());
    CHECK(symmetric_eigenvalues(bench.at(squeezed).hessian, n).front() < -1e-3);
    const DenseSystem projected = bench.at(squeezed, {.project = true, .pending = {}});
    CHECK(bench.assembler.projected_element_count() > 0);
    CHECK(symmetric_eigenvalues(projected.hessian, n).front() > -1e-12);
    CHECK(bench.at(mesh.vertices, {.project = true, .pending = {}}).hessian ==
          bench.at(mesh.vertices).hessian);
  }
}

TEST_CASE("prescribed nodes have no unknowns, and forces anticipate their motion to first order") {
  for (const SolidMesh& mesh : distorted_boxes({1, 1, 1})) {
    const std::vector<int32_t> prescribed{0, 3, 5};
    Bench all(mesh), some(mesh, prescribed);
    const std::vector<Vec3> x = shaken(mesh.vertices, 0.05);
    std::vector<Vec3> pending(x.size());
    RandomPoints random(8);
    for (const int32_t p : prescribed) pending[p] = random.point() * 0.1;
    const DenseSystem full = all.at(x), reduced = some.at(x, {.project = false, .pending = pending});
    const size_t n = full.gradient.size(), m = reduced.gradient.size();
    CHECK(m == n - 9);
    const auto unknown = [&](size_t p) { return 3 * static_cast<size_t>(some.map.point_block(int32_t(p))); };
    for (size_t p = 0; p < x.size(); ++p) {
      if (some.map.is_prescribed(int32_t(p))) continue;
      for (size_t c = 0; c < 3; ++c) {
        const size_t row = 3 * p + c;
        double expected = full.gradient[row];
        for (size_t j = 0; j < n; ++j)
          expected += full.hessian[row * n + j] * pending[j / 3][static_cast<int>(j % 3)];
        CHECK(std::fabs(reduced.gradient[unknown(p) + c] - expected) < 1e-13);
        for (size_t q = 0; q < x.size(); ++q)
          if (!some.map.is_prescribed(int32_t(q)))
            for (size_t d = 0; d < 3; ++d)
              CHECK(reduced.hessian[(unknown(p) + c) * m + unknown(q) + d] ==
                    full.hessian[row * n + 3 * q + d]);
      }
    }
  }
}

TEST_CASE("the result has the same bits on one thread and on three") {
  for (const SolidMesh& mesh : distorted_boxes({5, 5, 4})) {
    Bench one(mesh, {}, 1), three(mesh, {}, 3);
    const std::vector<Vec3> x = shaken(mesh.vertices, 0.02), y = shaken(mesh.vertices, 0.02, 6);
    std::vector<double> g(3 * x.size()), h(3 * x.size());
    BlockMatrix A, B;
    one.assembler.assemble({}, x, {.project = true, .pending = {}}, g, A);
    three.assembler.assemble({}, x, {.project = true, .pending = {}}, h, B);
    CHECK(g == h);
    CHECK(A.values == B.values);
    CHECK(one.assembler.static_energy_difference(y).difference ==
          three.assembler.static_energy_difference(y).difference);
  }
}

TEST_CASE("the gradient alone is that of the full assembly") {
  for (const SolidMesh& mesh : distorted_boxes({3, 2, 2})) {
    Bench bench(mesh, {0}, 2);
    const std::vector<Vec3> x = shaken(mesh.vertices, 0.02);
    const DenseSystem full = bench.at(x);
    bench.at(mesh.vertices);
    Configuration configuration;
    configuration.point_position = x;
    std::vector<double> gradient(full.gradient.size(), 1e30);
    bench.assembler.assemble_gradient(configuration, x, gradient);
    for (size_t i = 0; i < gradient.size(); ++i)
      CHECK(std::fabs(gradient[i] - full.gradient[i]) <= 1e-13 * largest(full.gradient));
    CHECK(bench.assembler.static_energy_difference(x).difference == 0.0);
  }
}
