// Elements of mean dilatation: derivatives against differences, the patch test, what they see of a change of
// volume, definiteness, bits, and the inf-sup test of their pressures.
#include <doctest/doctest.h>

#include <algorithm>
#include <cmath>

#include <stark/base/rotation.h>
#include <stark/mechanics/site_gradient.h>
#include <support/finite_differences.h>
#include <support/solid_bench.h>
#include <support/symmetric_eigen.h>

using namespace stark;
using namespace stark::test;

namespace {

const ParameterValues kValues{{"shear_modulus", {{2.0}, false}}, {"bulk_modulus", {{3.0}, false}}};

/// Meshes of the elements that have more than one point.
std::vector<SolidMesh> meshes(const Index3& cells, double distortion = 0.03) {
  std::vector<SolidMesh> all = distorted_boxes(cells, distortion);
  all.erase(all.begin());
  return all;
}

struct Bench {
  explicit Bench(const SolidMesh& m, const std::vector<int32_t>& prescribed = {}, int threads = 1,
                 const PotentialDefinition& definition = mean_dilatation_point(test_law()))
      : mesh(m),
        batch(make_quadrature_batch(m, definition, kValues)),
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

std::vector<SolidMesh> single_elements() {
  std::vector<SolidMesh> all = meshes({1, 1, 1});
  for (SolidMesh& mesh : all) mesh.elements.resize(mesh.node_count());
  return all;
}

}  // namespace

TEST_CASE("mean dilatation: gradient and Hessian agree with differences of energy and gradient") {
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
          [&](double t) { return bench.assembler.static_energy_difference(moved(i, t)).difference; }, 0.01);
      CHECK(std::fabs(slope - exact.gradient[i]) < 1e-8);
      const std::vector<double> row =
          differentiate([&](double t) { return bench.at(moved(i, t)).gradient; }, 0.01);
      for (size_t j = 0; j < n; ++j) CHECK(std::fabs(row[j] - exact.hessian[i * n + j]) < 1e-6);
      bench.at(x);  // the energies of reference for the next differences
    }
  }
}

TEST_CASE("mean dilatation: affine motion has psi(F) times the volume and carries no forces inside") {
  const Mat3 F = exp_rotation({0.2, 0.1, -0.3}) * Mat3::diagonal({1.2, 0.85, 1.05});
  for (const SolidMesh& mesh : meshes({2, 2, 2})) {
    std::vector<bool> on_boundary(mesh.vertices.size(), false);
    for (const Index3& t : find_boundary_triangles(mesh))
      for (const int32_t v : t) on_boundary[v] = true;
    Bench bench(mesh), plain(mesh, {}, 1, quadrature_point(test_law()));
    std::vector<Vec3> x;
    for (const Vec3& X : mesh.vertices) x.push_back(F * X);
    const DenseSystem system = bench.at(x);
    double largest = 0.0;
    int inside = 0;
    for (size_t i = 0; i < system.gradient.size(); ++i) {
      largest = std::fmax(largest, std::fabs(system.gradient[i]));
      if (on_boundary[i / 3]) continue;
      ++inside;
      CHECK(std::fabs(system.gradient[i]) < 1e-13);
    }
    CHECK(inside > 0);
    CHECK(largest > 1e-2);  // the boundary does carry forces
    CHECK(total_energy(bench.batch, x) == doctest::Approx(total_energy(plain.batch, x)).epsilon(1e-12));
  }
}

TEST_CASE(
    "mean dilatation: volume ratios are those of the motion, where they are linear in the rest position") {
  for (const SolidMesh& mesh : single_elements())
    for (const double slope : {0.0, 0.2}) {
      if (slope > 0.0 && mesh.node_count() < 27) continue;  // theirs are constant
      std::vector<Vec3> x = mesh.vertices;
      for (Vec3& p : x) p.x += 0.3 * p.x + 0.5 * slope * p.x * p.x;
      const std::vector<double> form = Bench(mesh).batch.volume_ratios(x);
      REQUIRE(form.size() == 4);
      // The sides of distorted elements of 27 nodes are quadratic, and x is more than that in them.
      const double within = slope > 0.0 ? 0.002 : 1e-12;
      CHECK(std::abs(form[0] - 1.3) < within);
      CHECK(std::abs(form[1] - slope) < within);
      CHECK(std::abs(form[2]) + std::abs(form[3]) < within);
    }
}

TEST_CASE("mean dilatation: changes of volume within an element cost nothing, that of the element does") {
  const SolidLaw volume =
      define_solid_law("volume", "", [](PotentialBuilder&, const SolidDeformation& deformation) {
        return 0.5 * symbolic::square(determinant(deformation.F()) - 1.0);
      });
  SolidMesh mesh = make_hex_box({1, 1, 1}, {1, 1, 1});
  Bench mean(mesh, {}, 1, mean_dilatation_point(volume)), plain(mesh, {}, 1, quadrature_point(volume));
  std::vector<Vec3> x = mesh.vertices;
  for (Vec3& p : x) p.z += 0.2 * p.x * p.z;  // an hourglass: one side longer, the other shorter
  CHECK(total_energy(mean.batch, x) < 1e-28);
  CHECK(total_energy(plain.batch, x) == doctest::Approx(0.5 * 0.04 / 12).epsilon(1e-12));  // x^2 to 1/12
  for (Vec3& p : x) p.y *= 1.1;
  CHECK(total_energy(mean.batch, x) == doctest::Approx(0.5 * 0.01).epsilon(1e-12));
}

TEST_CASE(
    "mean dilatation: projected Hessians are positive semidefinite, and the same where none is to project") {
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

TEST_CASE("mean dilatation: rigid motion changes no energy and leaves neither force nor torque") {
  const Mat3 R = exp_rotation({0.5, -1.2, 0.8});
  for (const SolidMesh& mesh : meshes({2, 1, 2})) {
    Bench bench(mesh);
    const std::vector<Vec3> x = shaken(mesh.vertices, 0.03);
    std::vector<Vec3> turned;
    for (const Vec3& p : x) turned.push_back(R * p + Vec3{1, 2, 3});
    const DenseSystem plain = bench.at(x);
    CHECK(std::fabs(bench.assembler.static_energy_difference(turned).difference) < 1e-13);
    Vec3 force, torque;
    for (size_t p = 0; p < x.size(); ++p) {
      const Vec3 f{plain.gradient[3 * p], plain.gradient[3 * p + 1], plain.gradient[3 * p + 2]};
      force += f;
      torque += cross(x[p], f);
    }
    CHECK(norm(force) < 1e-13);
    CHECK(norm(torque) < 1e-13);
  }
}

TEST_CASE("mean dilatation: the same bits on one thread and on three, and the gradient alone is the same") {
  for (const SolidMesh& mesh : meshes({4, 3, 2}, 0.01)) {
    Bench one(mesh, {0}, 1), three(mesh, {0}, 3);
    const std::vector<Vec3> x = shaken(mesh.vertices, 0.005), y = shaken(mesh.vertices, 0.005, 6);
    const size_t n = 3 * x.size() - 3;
    std::vector<double> g(n), h(n), alone(n);
    BlockMatrix A, B;
    one.assembler.assemble({}, x, {.project = true, .pending = {}}, g, A);
    three.assembler.assemble({}, x, {.project = true, .pending = {}}, h, B);
    CHECK(g == h);
    CHECK(A.values == B.values);
    CHECK(one.assembler.static_energy_difference(y).difference ==
          three.assembler.static_energy_difference(y).difference);
    Configuration configuration;
    configuration.point_position = x;
    one.assembler.assemble_gradient(configuration, x, alone);
    for (size_t i = 0; i < n; ++i) CHECK(std::fabs(alone[i] - g[i]) < 1e-13);
  }
}

TEST_CASE("mean dilatation: laws with memory see the volume ratio at the start of the step") {
  const SolidLaw rate =
      define_solid_law("rate", "", [](PotentialBuilder&, const SolidDeformation& deformation) {
        return symbolic::square(determinant(deformation.F()) - determinant(deformation.F_prev()));
      });
  SolidMesh mesh = make_hex_box({1, 1, 1}, {1, 1, 1});
  Bench bench(mesh, {}, 1, mean_dilatation_point(rate));
  std::vector<Vec3> before = mesh.vertices, now = mesh.vertices;
  for (Vec3& p : before) p.x *= 1.1;
  for (Vec3& p : now) p.x *= 1.3 + 0.5 * p.z;  // 1.3 in the mean: box_hexahedra is centred
  bench.batch.set_previous(before);
  CHECK(total_energy(bench.batch, now) == doctest::Approx(0.04).epsilon(1e-12));
}

namespace {

/// Eigenvalues of D S^-1 D^T, ascending, with the amplitudes D of the volume ratios, whose modes are
/// orthonormal, and the matrix S of the H1 seminorm, of a clamped cube.
std::vector<double> pressure_eigenvalues(const SolidMesh& mesh) {
  const SolidLaw stretch = define_solid_law(
      "stretch", "", [](PotentialBuilder&, const SolidDeformation& d) { return 0.5 * squared_norm(d.F()); });
  std::vector<int32_t> boundary;
  for (const Index3& t : find_boundary_triangles(mesh)) boundary.insert(boundary.end(), t.begin(), t.end());
  Bench norm(mesh, boundary, 1, quadrature_point(stretch)), mean(mesh, boundary);
  const size_t n = static_cast<size_t>(norm.map.layout().block_count);
  const std::vector<double> full = norm.at(mesh.vertices).hessian;
  std::vector<double> L(n * n);  // Cholesky factor of the scalar Laplacian; components do not mix
  for (size_t i = 0; i < n; ++i)
    for (size_t j = 0; j <= i; ++j) {
      double sum = full[3 * i * 3 * n + 3 * j];
      for (size_t k = 0; k < j; ++k) sum -= L[i * n + k] * L[j * n + k];
      L[i * n + j] = i == j ? std::sqrt(sum) : sum / L[j * n + j];
    }
  const MeanDilatation& dilatation = *mean.batch.dilatation();
  const int modes = dilatation.modes(), points = mean.batch.points_per_element();
  const size_t rows = static_cast<size_t>(mesh.element_count() * modes);
  std::vector<double> D(rows * 3 * n);
  for (int64_t e = 0; e < mesh.element_count(); ++e)
    for (int q = 0; q < points; ++q)
      for (int a = 0; a < mesh.node_count(); ++a) {
        const int32_t block = mean.map.point_block(mesh.element(e)[a]);
        if (block == kNoBlock) continue;
        for (int k = 0; k < modes; ++k)
          for (int c = 0; c < 3; ++c)
            D[(e * modes + k) * 3 * n + c * n + block] +=
                dilatation.weight(e, q) * dilatation.modes_at(e, q)[k] *
                mean.batch.gradients(e, q)[c * mean.batch.padded_nodes() + a];
      }
  for (size_t r = 0; r < rows; ++r)
    for (int c = 0; c < 3; ++c) {
      double* d = D.data() + r * 3 * n + c * n;
      for (size_t i = 0; i < n; ++i) {
        for (size_t k = 0; k < i; ++k) d[i] -= L[i * n + k] * d[k];
        d[i] /= L[i * n + i];
      }
    }
  std::vector<double> schur(rows * rows);
  for (size_t r = 0; r < rows; ++r)
    for (size_t s = 0; s < rows; ++s)
      for (size_t i = 0; i < 3 * n; ++i) schur[r * rows + s] += D[r * 3 * n + i] * D[s * 3 * n + i];
  return symmetric_eigenvalues(schur, static_cast<int>(rows));
}

/// How many pressures no displacement feels, and the inf-sup constant of the others.
std::pair<int, double> inf_sup(const SolidMesh& mesh) {
  const std::vector<double> eigenvalues = pressure_eigenvalues(mesh);
  const auto first = std::find_if(eigenvalues.begin(), eigenvalues.end(), [](double e) { return e > 1e-10; });
  return {static_cast<int>(first - eigenvalues.begin()), std::sqrt(*first)};
}

SolidMesh cube(int cells, bool tetrahedra) {
  const Index3 n{cells, cells, cells};
  return tetrahedra ? SolidMesh(make_tet_box({1, 1, 1}, n)) : make_hex_box({1, 1, 1}, n);
}

}  // namespace

TEST_CASE("inf-sup test: the constant of 27-node hexahedra does not fall with the size of the elements") {
  // Chapelle, Bathe 1993, "The inf-sup test". One pressure alone does nothing: the constant one.
  std::vector<double> constants;
  for (const int cells : {2, 3, 4}) {
    const auto [silent, constant] = inf_sup(to_quadratic(cube(cells, false)));
    CHECK(silent == 1);
    constants.push_back(constant);
  }
  CHECK(constants[0] == doctest::Approx(0.395).epsilon(0.01));  // as measured
  CHECK(constants[1] > 0.99 * constants[0]);
  CHECK(constants[2] > 0.97 * constants[0]);
}

TEST_CASE("inf-sup test: 10-node tetrahedra pass on these meshes, 8-node hexahedra have checkerboards") {
  std::vector<double> tets, hexes;
  for (const int cells : {1, 2, 3}) {
    const auto [silent, constant] = inf_sup(to_quadratic(cube(cells, true)));
    CHECK(silent == 1);
    tets.push_back(constant);
  }
  CHECK(tets[2] > 0.95 * tets[1]);
  std::vector<int> checkerboards;
  for (const int cells : {2, 4}) {
    const auto [silent, constant] = inf_sup(cube(cells, false));
    checkerboards.push_back(silent - 1);
    hexes.push_back(constant);
  }
  CHECK(checkerboards == std::vector<int>{4, 10});
  CHECK(hexes[1] < 0.5 * hexes[0]);  // falls with the size
}
