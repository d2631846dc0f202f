// Speed of the linear algebra: ordering, symbolic and numerical Cholesky, solves, conjugate gradients, PSD
// projection. Usage: bench_linalg [threads [folder]]; the folder gets the systems, for pardiso.py. Times are
// the best of several runs, in milliseconds: of CPU time on one thread, which a busy machine disturbs least,
// of wall time otherwise.
#include <algorithm>
#include <chrono>
#include <cstdio>
#include <cstdlib>
#include <ctime>
#include <fstream>
#include <random>
#include <string>
#include <vector>

#include <stark/base/psd.h>
#include <stark/linalg/automatic_solver.h>
#include <stark/linalg/cholesky.h>
#include <stark/linalg/jacobi_matrix.h>
#include <stark/linalg/pcg.h>

#include "linalg/systems.h"

namespace {

using namespace stark;

bool one_thread = true;
std::string dump_folder;

double now_ms() {
  if (one_thread) return 1e3 * static_cast<double>(std::clock()) / CLOCKS_PER_SEC;
  const std::chrono::duration<double, std::milli> now = std::chrono::steady_clock::now().time_since_epoch();
  return now.count();
}

template <typename Body>
double best_ms(int runs, Body&& body) {
  double best = 1e300;
  for (int k = 0; k < runs; ++k) {
    const double start = now_ms();
    body();
    best = std::min(best, now_ms() - start);
  }
  return best;
}

// The upper triangle by scalar rows: n and the number of entries, starts of rows, all int64; columns, int32;
// values, double.
void dump(std::string name, const BlockMatrix& matrix) {
  const BlockPattern& pattern = matrix.pattern;
  std::vector<int64_t> start{0};
  std::vector<int32_t> column;
  std::vector<double> value;
  for (int32_t i = 0; i < pattern.block_count; ++i)
    for (int r = 0; r < 3; ++r) {
      for (int64_t slot = pattern.row_start[i]; slot < pattern.row_start[i + 1]; ++slot)
        for (int c = pattern.column[slot] == i ? r : 0; c < 3; ++c) {
          column.push_back(3 * pattern.column[slot] + c);
          value.push_back(matrix.values[9 * slot + 3 * r + c]);
        }
      start.push_back(static_cast<int64_t>(column.size()));
    }
  std::replace(name.begin(), name.end(), ' ', '_');
  std::ofstream file(dump_folder + "/" + name + ".bin", std::ios::binary);
  const auto write = [&](const auto& numbers) {
    file.write(reinterpret_cast<const char*>(numbers.data()),
               static_cast<std::streamsize>(numbers.size() * sizeof(numbers[0])));
  };
  write(std::vector<int64_t>{3 * static_cast<int64_t>(pattern.block_count), start.back()});
  write(start), write(column), write(value);
}

template <typename Real>
void run_factor(const char* precision, const BlockMatrix& matrix, const std::vector<double>& b,
                ThreadPool& pool) {
  Cholesky<Real> cholesky;
  std::vector<double> x(b.size());
  const double first = best_ms(1, [&] { cholesky.analyze(matrix.pattern, pool); });
  const double symbolic = best_ms(5, [&] { cholesky.analyze(matrix.pattern, pool); });
  const double factor = best_ms(7, [&] { cholesky.factor(matrix, pool); });
  const double solve = best_ms(5, [&] { cholesky.solve(b.data(), x.data(), pool); });
  std::printf(
      "  %s: lnz %.2f M, %.3f Gflop; ordering + symbolic %.1f, symbolic %.2f, factor %.2f (%.1f GF/s), solve "
      "%.2f; "
      "residual %.1e\n",
      precision, 1e-6 * static_cast<double>(cholesky.factor_nonzeros()), 1e-9 * cholesky.flops(), first,
      symbolic, factor, 1e-6 * cholesky.flops() / factor, solve, test::relative_residual(matrix, b, x));
}

void run_system(const char* name, int32_t blocks, const test::Pairs& pairs, ThreadPool& pool) {
  const BlockMatrix matrix = test::spd_matrix(BlockPattern::from_pairs(blocks, pairs), 1);
  const std::vector<double> b = test::random_vector(3 * static_cast<int64_t>(blocks), 2);
  const double pattern = best_ms(3, [&] { BlockPattern::from_pairs(blocks, pairs); });
  const double hash = best_ms(3, [&] { matrix.pattern.hash(); });
  std::printf("%s: %d dofs, %lld blocks; pattern %.2f, hash %.3f\n", name, 3 * blocks,
              static_cast<long long>(matrix.pattern.slot_count()), pattern, hash);
  if (!dump_folder.empty()) dump(name, matrix);
  run_factor<double>("double", matrix, b, pool);
  run_factor<float>("float ", matrix, b, pool);
  for (PcgStorage storage : {PcgStorage::Double, PcgStorage::Float}) {
    Pcg pcg;
    JacobiMatrix jacobi;
    std::vector<double> x(b.size());
    jacobi.prepare(matrix, storage, pool);
    const double prepare = best_ms(3, [&] { jacobi.prepare(matrix, storage, pool); });
    PcgReport report;
    const double time = best_ms(3, [&] { report = pcg.solve(jacobi, b, x, 1e-30, 50, pool); });
    std::printf("  pcg %s storage: prepare %.2f, iteration %.3f\n",
                storage == PcgStorage::Double ? "double" : "float", prepare, time / report.iterations);
  }
}

// A stack of 27 rigid bodies of two block rows each, every body touching its six neighbours.
void run_tiny(ThreadPool& pool) {
  test::Pairs pairs;
  const auto couple = [&](int a, int b) {
    for (int i = 0; i < 2; ++i)
      for (int j = 0; j < 2; ++j) pairs.emplace_back(2 * a + i, 2 * b + j);
  };
  for (int a = 0; a < 27; ++a) {
    couple(a, a);
    if (a % 3 < 2) couple(a, a + 1);
    if (a / 3 % 3 < 2) couple(a, a + 3);
    if (a < 18) couple(a, a + 9);
  }
  const BlockMatrix matrix = test::spd_matrix(BlockPattern::from_pairs(54, pairs), 1);
  BlockMatrix other = test::spd_matrix(BlockPattern::from_pairs(54,
                                                                [&] {
                                                                  auto p = pairs;
                                                                  p.emplace_back(0, 53);
                                                                  return p;
                                                                }()),
                                       1);
  const std::vector<double> b = test::random_vector(162, 2);
  std::vector<double> x(b.size());
  AutomaticSolver solver({}, pool);
  const double same = best_ms(200, [&] { solver.solve({.A = matrix, .b = b}, x); });
  int k = 0;
  const double changing = best_ms(200, [&] { solver.solve({.A = ++k % 2 ? other : matrix, .b = b}, x); });
  std::printf(
      "27 rigid bodies (162 dofs): LinearSolver::solve %.1f us, with a new pattern every time %.1f us\n",
      1e3 * same, 1e3 * changing);
}

void run_psd() {
  std::mt19937 random(1);
  std::normal_distribution<double> normal;
  for (int n : {3, 6, 9, 12, 15, 18}) {
    // Sum of a random symmetric matrix and a multiple of the identity: some negative eigenvalues.
    const int size = n * (n + 1) / 2, batches = 64;
    std::vector<double> source(static_cast<size_t>(batches) * size * kPsdLanes), work;
    for (double& value : source) value = normal(random);
    volatile uint32_t sink = 0;
    const double test_time = best_ms(5, [&] {
      for (int k = 0; k < batches; ++k) sink = sink + psd_test(source.data() + k * size * kPsdLanes, n);
    });
    double project[2] = {0.0, 0.0};
    for (int invariant = 0; invariant < (n > 3 ? 2 : 1); ++invariant)
      project[invariant] = best_ms(5, [&] {
        work = source;
        for (int k = 0; k < batches; ++k)
          psd_project(work.data() + k * size * kPsdLanes, n, 0xffu, invariant != 0);
      });
    const double scale = 1e6 / (batches * kPsdLanes);
    std::printf("psd %2d x %2d: test %.0f ns, projection %.0f ns, translation-invariant %.0f ns per matrix\n",
                n, n, scale * test_time, scale * project[0], scale * project[1]);
  }
}

}  // namespace

int main(int argc, char** argv) {
  ThreadPool pool(argc > 1 ? std::atoi(argv[1]) : 1);
  if (argc > 2) dump_folder = argv[2];
  one_thread = pool.thread_count() == 1;
  std::printf("%d threads; milliseconds of %s time\n", pool.thread_count(), one_thread ? "CPU" : "wall");
  run_tiny(pool);
  run_psd();
  run_system("cloth 60 x 60", 60 * 60, test::cloth_pairs(60), pool);
  run_system("cloth 128 x 128", 128 * 128, test::cloth_pairs(128), pool);
  test::Pairs folded = test::cloth_pairs(128);
  std::mt19937 random(1);
  for (int k = 0; k < 20000; ++k) {
    const int i = static_cast<int>(random() % 128), j = static_cast<int>(random() % 60);
    const int other = std::clamp(i + static_cast<int>(random() % 3) - 1, 0, 127);
    folded.emplace_back(i * 128 + j, other * 128 + 127 - j - static_cast<int>(random() % 2));
  }
  run_system("cloth 128 x 128 folded on itself", 128 * 128, folded, pool);
  for (int n : {10, 20}) {
    int32_t count = 0;
    const test::Pairs pairs = test::solid_pairs(n, count);
    run_system(n == 10 ? "solid 10^3 cells" : "solid 20^3 cells", count, pairs, pool);
  }
  return 0;
}
