// See cut_rule.h.
#include <stark/geometry/cut_rule.h>

#include <algorithm>
#include <cmath>
#include <numbers>

#include <stark/geometry/nonnegative_fit.h>

namespace stark {

namespace {

/// Part of an empty cell that counts as filled evenly besides what is [finite cell method: Parvizian,
/// Duester, Rank 2007]: slivers hold their nodes by it. It falls with what is empty to this power. Four
/// times as much makes plates of a third of a cell 20 % too stiff, half of it leaves vertices at slivers
/// softer.
constexpr double kEvenly = 0.0005;
constexpr int kFall = 4;

constexpr double kRounding = 1e-9;  ///< of moments
constexpr int kRootSteps = 40;

/// Candidates for points along an axis, at the cosines of even angles so that there are more near faces. What
/// is thin, or cut askew, may take more of them.
constexpr std::array kCandidates{7, 13};
constexpr double kEnough = 1e-4;  ///< error of integrals over the volume of what is filled
constexpr int kNodes = 27;

/// Moments over a volume of one.
std::array<double, 27> mixed_moments(const CellFilling& filling) {
  const std::array<double, 27> full = CellFilling::of_full_cell();
  const double evenly = kEvenly * std::pow(1.0 - filling.part(), kFall);
  std::array<double, 27> result;
  for (size_t m = 0; m < result.size(); ++m)
    result[m] = (filling.moments[m] + evenly * full[m]) / (filling.part() + evenly);
  return result;
}

/// Square root of a symmetric positive definite matrix [Denman, Beavers 1976].
Mat3 square_root(const Mat3& C) {
  Mat3 root = C, inverse_root = Mat3::identity();
  for (int k = 0; k < kRootSteps; ++k) {
    const Mat3 next = (root + inverse(inverse_root)) * 0.5;
    inverse_root = (inverse_root + inverse(root)) * 0.5;
    root = next;
  }
  return root;
}

/// Gauss's rule in the parallelepiped with these moments up to the second order. Of all roots of the second
/// moments the symmetric one keeps the symmetries of what is filled.
std::vector<QuadraturePoint> moved_rule(const std::array<double, 27>& m) {
  const Vec3 mean{m[1], m[3], m[9]};
  const Mat3 second{{m[2], m[4], m[10], m[4], m[6], m[12], m[10], m[12], m[18]}};
  const Mat3 root = square_root(second - outer(mean, mean));
  std::vector<QuadraturePoint> rule = reference_element(ElementType::Hex8).quadrature;
  for (QuadraturePoint& q : rule)
    q.position = mean + root * ((q.position - Vec3{0.5, 0.5, 0.5}) * std::sqrt(12.0));
  return rule;
}

struct Candidates {
  std::vector<Vec3> positions;
  std::vector<double> shapes;  ///< [candidate][node]

  explicit Candidates(int along_axis) {
    std::vector<double> places;
    for (int k = 0; k < along_axis; ++k)
      places.push_back(0.5 - 0.5 * std::cos(k * std::numbers::pi / (along_axis - 1)));
    for (const double z : places)
      for (const double y : places)
        for (const double x : places) positions.push_back({x, y, z});
    shapes.resize(positions.size() * kNodes);
    for (size_t c = 0; c < positions.size(); ++c)
      shape_functions(ElementType::Hex27, positions[c], std::span(shapes).subspan(c * kNodes, kNodes));
  }
};

/// Integrals of the shape functions of 27 nodes.
std::vector<double> shape_integrals(const std::array<double, 27>& moments) {
  // Of the quadratic shape functions of 0, 1/2 and 1: coefficients of 1, x and x^2.
  constexpr double kCoefficients[3][3] = {{1.0, -3.0, 2.0}, {0.0, 4.0, -4.0}, {0.0, -1.0, 2.0}};
  std::vector<double> result;
  for (const Vec3& node : reference_element(ElementType::Hex27).nodes) {
    const auto along = [&](int axis) { return kCoefficients[static_cast<int>(2.0 * node[axis] + 0.5)]; };
    double sum = 0.0;
    for (int k = 0; k < 3; ++k)
      for (int j = 0; j < 3; ++j)
        for (int i = 0; i < 3; ++i)
          sum += along(0)[i] * along(1)[j] * along(2)[k] * moments[i + 3 * j + 9 * k];
    result.push_back(sum);
  }
  return result;
}

/// What the integrals of weighted candidates are off by.
double error_of(const Candidates& all, std::span<const double> weights, std::vector<double> integrals) {
  for (size_t c = 0; c < weights.size(); ++c)
    for (int a = 0; a < kNodes; ++a) integrals[a] -= weights[c] * all.shapes[c * kNodes + a];
  double error = 0.0;
  for (const double missing : integrals) error = std::max(error, std::fabs(missing));
  return error;
}

/// Weights of the same points among more candidates, of which each second one along an axis is there.
std::vector<double> among_finer(const std::vector<double>& weights) {
  constexpr int n = kCandidates[0], m = kCandidates[1];
  static_assert(m == 2 * n - 1);
  std::vector<double> result(static_cast<size_t>(m) * m * m, 0.0);
  for (int z = 0; z < n; ++z)
    for (int y = 0; y < n; ++y)
      for (int x = 0; x < n; ++x) result[(2 * z * m + 2 * y) * m + 2 * x] = weights[(z * n + y) * n + x];
  return result;
}

/// Few of many points, with weights that have all moments [moment fitting: Mueller, Kummer, Oberlack 2013]:
/// a solution with positive weights has no more points than there are moments.
std::vector<QuadraturePoint> fitted_rule(const std::array<double, 27>& moments) {
  static const Candidates coarse(kCandidates[0]), fine(kCandidates[1]);
  const std::vector<double> integrals = shape_integrals(moments);
  const Candidates* all = &coarse;
  std::vector<double> weights = nonnegative_fit(coarse.shapes, integrals);
  if (error_of(coarse, weights, integrals) > kEnough) {
    all = &fine;
    weights = nonnegative_fit(fine.shapes, integrals, among_finer(weights));
  }
  std::vector<QuadraturePoint> rule;
  for (size_t c = 0; c < weights.size(); ++c)
    if (weights[c] > 0.0) rule.push_back({all->positions[c], weights[c]});
  double sum = 0.0;
  for (const QuadraturePoint& q : rule) sum += q.weight;
  for (QuadraturePoint& q : rule) q.weight /= sum;
  // Those that are missing halve the heaviest ones: none is without weight.
  while (!rule.empty() && rule.size() < kNodes) {
    const auto heaviest = std::ranges::max_element(rule, {}, &QuadraturePoint::weight);
    heaviest->weight *= 0.5;
    rule.push_back(QuadraturePoint(*heaviest));
  }
  return rule;
}

}  // namespace

std::vector<QuadraturePoint> cut_rule(ElementType type, const CellFilling& filling) {
  const std::array<double, 27> moments = mixed_moments(filling);
  return type == ElementType::Hex27 ? fitted_rule(moments) : moved_rule(moments);
}

bool is_of_a_cell(const CellFilling& filling) {
  const double part = filling.part();
  if (!(part > 0.0 && part <= 1.0)) return false;
  const double slack = kRounding * part;
  for (const double m : filling.moments)
    if (!(m >= -slack && m <= part + slack)) return false;
  const std::array<double, 27>& m = filling.moments;
  const Vec3 mean = filling.mean();
  const Mat3 C =
      Mat3{{m[2], m[4], m[10], m[4], m[6], m[12], m[10], m[12], m[18]}} * (1.0 / part) - outer(mean, mean);
  for (int i = 0; i < 3; ++i) {
    const int j = (i + 1) % 3;
    if (C(i, i) < -kRounding || C(i, j) * C(i, j) > C(i, i) * C(j, j) + kRounding) return false;
  }
  return determinant(C) >= -kRounding;
}

}  // namespace stark
