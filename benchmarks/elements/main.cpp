// Time of energy and of gradient with projected Hessian, assembled into the block matrix, per element of each
// type with the stable Neo-Hookean law, on one thread. usage: bench_elements
#include <stark/mechanics/assembler.h>
#include <stark/sim/scene/registry.h>

#include <algorithm>
#include <chrono>
#include <cstdio>

#include <support/solid_bench.h>

namespace {

using namespace stark;
using Clock = std::chrono::steady_clock;

/// Fewest nanoseconds of many runs: the machine may be shared.
template <typename Run>
double fastest(Run&& run) {
  double best = 1e18;
  for (int k = 0; k < 30; ++k) {
    const auto start = Clock::now();
    run();
    best = std::min(best, std::chrono::duration<double, std::nano>(Clock::now() - start).count());
  }
  return best;
}

void measure(const SolidMesh& mesh) {
  const ParameterValues values{{"youngs_modulus", {{1e5}, false}}, {"poissons_ratio", {{0.4}, false}}};
  const KinematicMap map = test::point_map(mesh.vertices.size());
  ThreadPool pool(1);
  Assembler assembler(map, pool);
  PotentialBatch linear(
      std::make_shared<Potential>(tet4(models::stable_neo_hookean()), symbolic::Backend::Automatic));
  const QuadratureBatch points =
      test::make_quadrature_batch(mesh, quadrature_point(models::stable_neo_hookean()), values);
  if (mesh.type == ElementType::Tet4) {
    linear.resize(mesh.elements);
    linear.set_rest(mesh.vertices);
    set_values(linear, values);
    assembler.set_static_batches({&linear});
  } else {
    assembler.set_static_batches({}, {&points});
  }
  std::vector<Vec3> x = mesh.vertices;
  test::RandomPoints random(3);
  for (Vec3& p : x) p += random.point() * 0.01;
  std::vector<double> gradient(3 * x.size());
  BlockMatrix hessian;
  const auto assemble = [&](bool project) {
    assembler.assemble({}, x, {.project = project, .pending = {}}, gradient, hessian);
  };
  const double count = static_cast<double>(mesh.element_count());
  const double energy = fastest([&] { assembler.static_energy_difference(x); }) / count;
  const double plain = fastest([&] { assemble(false); }) / count;
  const double projected = fastest([&] { assemble(true); }) / count;
  std::printf("| %s | %d | %zu | %.0f | %.0f | %.0f |\n",
              std::string(reference_element(mesh.type).name).c_str(), static_cast<int>(mesh.element_count()),
              mesh.vertices.size(), energy, plain, projected);
}

}  // namespace

int main() {
  std::printf("| element | elements | nodes | energy [ns] | assembly [ns] | projected [ns] |\n");
  std::printf("|---|--:|--:|--:|--:|--:|\n");
  const SolidMesh tets = make_tet_box({1, 1, 1}, {8, 8, 8}), hexes = make_hex_box({1, 1, 1}, {12, 12, 12});
  for (const SolidMesh& mesh : {tets, to_quadratic(tets), hexes, to_quadratic(hexes)}) measure(mesh);
  return 0;
}
