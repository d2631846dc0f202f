#include <stark/mechanics/congruence.h>

namespace stark {

namespace {

/// J^T H J of a term of each of two sites.
Mat3 transposed_product(const SiteJacobian& p, const JacobianTerm& a, const Mat3& H, const SiteJacobian& q,
                        const JacobianTerm& b) {
  Mat3 block = H;
  if (a.is_rotation) block = skew(p.lever) * block;
  if (b.is_rotation) block = block * skew(-q.lever);
  const double weight = a.weight * b.weight;
  return weight == 1.0 ? block : block * weight;
}

}  // namespace

void pending_gradient(const ElementView& element, std::span<const int32_t> sites, const KinematicMap& map,
                      std::span<const Vec3> pending, std::span<Vec3> out) {
  const int points = static_cast<int>(sites.size());
  for (Vec3& g : out) g = {};
  for (int j = 0; j < points; ++j) {
    if (!map.is_prescribed(sites[j])) continue;
    const Vec3& d = pending[sites[j]];
    if (d == Vec3{}) continue;
    for (int i = 0; i < points; ++i) out[i] += element.point_hessian(i, j) * d;
  }
}

void add_point_element(const ElementView& element, std::span<const int32_t> blocks,
                       std::span<const Vec3> extra_gradient, const RowRange& rows, std::span<double> gradient,
                       BlockMatrix& hessian) {
  const int points = static_cast<int>(blocks.size());
  for (int p = 0; p < points; ++p) {
    if (blocks[p] == kNoBlock || !rows.has(blocks[p])) continue;
    Vec3 g = element.point_gradient(p);
    if (!extra_gradient.empty()) g += extra_gradient[p];
    for (int c = 0; c < 3; ++c) gradient[3 * blocks[p] + c] += g[c];
    for (int q = 0; q < points; ++q) {
      if (blocks[q] < blocks[p]) continue;  // prescribed, or the transposed pair adds it
      double* values = hessian.values.data() + 9 * hessian.pattern.slot(blocks[p], blocks[q]);
      const Mat3 H = element.point_hessian(p, q);
      for (int c = 0; c < 9; ++c) values[c] += H.m[c];
    }
  }
}

void add_mapped_gradient(const SiteJacobian& jacobian, const Vec3& g, std::span<double> gradient) {
  for (int k = 0; k < jacobian.term_count; ++k) {
    const JacobianTerm& term = jacobian.terms[k];
    const Vec3 f = jacobian.pull_back(term, g);
    for (int c = 0; c < 3; ++c) gradient[3 * term.block + c] += f[c];
  }
  for (size_t k = 0; k < jacobian.support_blocks.size(); ++k) {
    const int32_t block = jacobian.support_blocks[k];
    if (block == kNoBlock) continue;
    for (int c = 0; c < 3; ++c) gradient[3 * block + c] += g[c] * jacobian.support_weights[k];
  }
}

void add_mapped_gradients(const ElementView& element, std::span<const SiteJacobian> jacobians,
                          std::span<const Vec3> extra_gradient, std::span<double> gradient,
                          std::span<Mat3> body_moment) {
  for (size_t p = 0; p < jacobians.size(); ++p) {
    const SiteJacobian& site = jacobians[p];
    if (site.is_zero()) continue;
    Vec3 g = element.point_gradient(static_cast<int>(p));
    if (site.body >= 0) body_moment[site.body] += outer(g, site.lever);
    if (!extra_gradient.empty()) g += extra_gradient[p];
    add_mapped_gradient(site, g, gradient);
  }
}

void add_mapped_hessian(const ElementView& element, std::span<const int32_t> sites,
                        std::span<const SiteJacobian> jacobians, BlockMatrix& hessian, SitePairs& pairs) {
  const int points = static_cast<int>(jacobians.size());
  for (int p = 0; p < points; ++p) {
    const SiteJacobian& site = jacobians[p];
    if (site.is_zero()) continue;
    for (int q = 0; q < points; ++q) {
      const SiteJacobian& other = jacobians[q];
      if (other.is_zero()) continue;
      const Mat3 H = element.point_hessian(p, q);
      if (site.is_embedded() || other.is_embedded()) {
        if (sites[p] == sites[q] || p < q) pairs.add(sites[p], sites[q], H);
        continue;
      }
      for (int k = 0; k < site.term_count; ++k)
        for (int l = 0; l < other.term_count; ++l) {
          const JacobianTerm &a = site.terms[k], &b = other.terms[l];
          if (a.block > b.block) continue;  // the transposed pair adds it
          const Mat3 block = transposed_product(site, a, H, other, b);
          double* values = hessian.values.data() + 9 * hessian.pattern.slot(a.block, b.block);
          for (int c = 0; c < 9; ++c) values[c] += block.m[c];
        }
    }
  }
}

}  // namespace stark
