// Block systems for the tests of linalg: meshes of cloth and solids, random graphs, and dense oracles.
#pragma once

#include <cstdint>
#include <random>
#include <utility>
#include <vector>

#include <stark/linalg/block_matrix.h>

namespace stark::test {

using Pairs = std::vector<std::pair<int32_t, int32_t>>;

/// Couplings of an n x n cloth: triangle edges and the opposite corners of hinges.
Pairs cloth_pairs(int n);
/// Couplings of an n^3 grid of cells with a node in the centre of each, five tetrahedra-like cliques per
/// cell.
Pairs solid_pairs(int n, int32_t& out_block_count);
Pairs random_pairs(int32_t block_count, int count, uint32_t seed);

/// A graph with a name.
struct GraphCase {
  const char* name;
  int32_t block_count;
  Pairs pairs;
};

/// Meshes and awkward graphs for orderings: isolated nodes, random, a star, a mesh with a node that touches
/// everything.
std::vector<GraphCase> ordering_cases();

bool is_permutation_of_all(std::vector<int32_t> order, int32_t count);

/// Symmetric positive definite values: each coupling adds k (e e^T tensor random PSD 3x3), every node a mass.
/// `contrast` is the ratio of the stiffest to the softest coupling.
BlockMatrix spd_matrix(BlockPattern pattern, uint32_t seed, double contrast = 1e4);

std::vector<double> random_vector(int64_t size, uint32_t seed);

/// Dense copy, row-major, and the solution by dense Gaussian elimination with partial pivoting in long
/// double.
std::vector<long double> dense_of(const BlockMatrix& matrix);
std::vector<double> dense_solve(const BlockMatrix& matrix, const std::vector<double>& b);

/// |b - A x| / |b|, the product summed in long double.
double relative_residual(const BlockMatrix& matrix, const std::vector<double>& b,
                         const std::vector<double>& x);

}  // namespace stark::test
