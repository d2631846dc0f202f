#include <stark/contact/stiffness.h>

#include <algorithm>
#include <cmath>

#include <stark/base/psd.h>

namespace stark {

namespace {

/// b''(d_hat/2) of b = -(d - d_hat)^2 ln(d/d_hat): 2 ln 2 + 4 + 1.
const double kMiddleCurvature = 2.0 * std::log(2.0) + 5.0;

/// Compliance that no pair falls below [m/N], so that kappa stays finite whatever the input.
constexpr double kSmallestCompliance = 1e-30;

}  // namespace

void PairStiffness::begin_step(const Configuration& configuration, std::span<const Mat3> diagonal,
                               double factor) {
  configuration_ = configuration;
  factor_ = factor;
  frozen_.clear();
  inverse_diagonal_.clear();
  for (const Mat3& block : diagonal) {
    // Indefinite blocks (buckled elements) lose their negative part; a multiple of the identity keeps them
    // invertible.
    Mat3 safe = psd_project(block);
    const double shift = 1e-6 * trace(safe) + 1e-300;
    inverse_diagonal_.push_back(inverse(safe + Mat3::identity() * shift));
  }
}

double PairStiffness::compliance(const Contact& contact, std::span<const Vec3> x) const {
  Vec3 n;
  for (int p = 0; p < contact.point_count; ++p) n += x[contact.sites[p]] * contact.weights[p];
  n = n / norm(n);
  std::array<std::pair<int32_t, Vec3>, 16> terms;  // block and its generalised direction
  int count = 0;
  for (int p = 0; p < contact.point_count; ++p) {
    const SiteJacobian site = map_.jacobian(contact.sites[p], configuration_);
    for (int k = 0; k < site.term_count; ++k) {
      const JacobianTerm& term = site.terms[k];
      const Vec3 j = (term.is_identity ? n : transpose(term.J) * n) * (term.weight * contact.weights[p]);
      const auto found = std::find_if(terms.begin(), terms.begin() + count,
                                      [&](const auto& t) { return t.first == term.block; });
      if (found != terms.begin() + count)
        found->second += j;
      else
        terms[count++] = {term.block, j};
    }
  }
  double compliance = 0.0;
  for (int k = 0; k < count; ++k)
    compliance += dot(terms[k].second, inverse_diagonal_[terms[k].first] * terms[k].second);
  return std::max(compliance, kSmallestCompliance);
}

void PairStiffness::assign(std::span<const Vec3> x, std::vector<Contact>& contacts) {
  for (Contact& contact : contacts) {
    const auto [entry, is_new] = frozen_.try_emplace(contact.key, 0.0);
    if (is_new) entry->second = factor_ / (kMiddleCurvature * compliance(contact, x));
    contact.stiffness = entry->second;
  }
}

}  // namespace stark
