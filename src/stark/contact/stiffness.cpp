#include <stark/contact/stiffness.h>

#include <algorithm>
#include <cmath>

#include <stark/base/psd.h>

namespace stark {

namespace {

/// b''(d_hat/2) of b = -(d - d_hat)^2 ln(d/d_hat): 2 ln 2 + 4 + 1.
const double kMiddleCurvature = 2.0 * std::log(2.0) + 5.0;

/// Part of the contact distance at which a load is carried that asks for more than inertia and elasticity do,
/// and slope of the barrier there: -b'(r d_hat) / d_hat.
constexpr double kLoadedGap = 0.1;
const double kLoadedSlope =
    2.0 * (kLoadedGap - 1.0) * std::log(kLoadedGap) + (1.0 - kLoadedGap) * (1.0 - kLoadedGap) / kLoadedGap;

/// Growth and decay of a factor in a full time step, less in one cut short: an impact is not a load, and a
/// load that moves from contact to contact must not pump.
constexpr double kGrowth = 2.0, kDecay = 0.9;

/// A factor stays while the load asks for no less than this part of it and no more than its inverse: a body
/// at rest is to rest.
constexpr double kEnough = 0.8;

/// Growth of a factor after an attempt that failed, and where that ends.
constexpr double kRaise = 1e3, kHighest = 1e9;

double next_factor(double factor, double wanted, double share) {
  if (wanted > factor / kEnough) return std::min(wanted, std::pow(kGrowth, share) * factor);
  return wanted < kEnough * factor ? std::max(wanted, std::pow(kDecay, share) * factor) : factor;
}

/// Compliance that no pair falls below: part of that of the softest vertex of its primitives. Weights come
/// and go while a contact slides over triangles that are partly prescribed, kappa stays.
constexpr double kSmallestShare = 1e-2;

struct PairSites {
  std::array<int32_t, 4> site;
  int count;
};

/// Vertices of both primitives.
PairSites sites_of(const SurfaceMesh& mesh, const PairKey& key) {
  switch (key.list) {
    case 0: {
      const Index3& t = mesh.triangles[key.second];
      return {{key.first, t[0], t[1], t[2]}, 4};
    }
    case 1: {
      const Index2 &a = mesh.edges[key.first], &b = mesh.edges[key.second];
      return {{a[0], a[1], b[0], b[1]}, 4};
    }
    case 2: {
      const Index2& e = mesh.edges[key.second];
      return {{key.first, e[0], e[1]}, 3};
    }
    default:
      return {{key.first, key.second}, 2};
  }
}

Vec3 normal_of(const Contact& contact, std::span<const Vec3> x) {
  Vec3 n;
  for (int p = 0; p < contact.point_count; ++p) n += x[contact.sites[p]] * contact.weights[p];
  return normalized(n);
}

}  // namespace

int64_t LoadMemory::code(const Contact& contact) {
  const auto [a, b] = std::minmax(contact.group_a, contact.group_b);
  return (static_cast<int64_t>(a) << 32) | b;
}

void LoadMemory::add(int64_t code, double value) {
  if (!(value > 1.0)) return;
  bodies.push_back(code);
  factor.push_back(value);
}

double LoadMemory::find(int64_t code) const {
  const auto found = std::ranges::lower_bound(bodies, code);
  return found != bodies.end() && *found == code ? factor[found - bodies.begin()] : 1.0;
}

void PairStiffness::begin_step(const Configuration& configuration, std::span<const Mat3> diagonal,
                               double factor, LoadMemory memory) {
  configuration_ = configuration;
  factor_ = factor;
  memory_ = std::move(memory);
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
  const auto count = static_cast<size_t>(contact.point_count);
  return compliance(std::span(contact.sites).first(count), std::span(contact.weights).first(count),
                    normal_of(contact, x));
}

double PairStiffness::compliance(std::span<const int32_t> sites, std::span<const double> weights,
                                 const Vec3& n) const {
  std::array<std::pair<int32_t, Vec3>, 16> terms;  // block and its generalised direction
  int count = 0;
  for (size_t p = 0; p < sites.size(); ++p) {
    const SiteJacobian site = map_.jacobian(sites[p], configuration_);
    for (int k = 0; k < site.term_count; ++k) {
      const JacobianTerm& term = site.terms[k];
      const Vec3 j = (term.is_identity ? n : transpose(term.J) * n) * (term.weight * weights[p]);
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
  return compliance;
}

double PairStiffness::natural(const SurfaceMesh& mesh, const Contact& contact,
                              std::span<const Vec3> x) const {
  const Vec3 n = normal_of(contact, x);
  const double one = 1.0;
  double softest = 0.0;
  const PairSites vertices = sites_of(mesh, contact.key);
  for (const int32_t& site : std::span(vertices.site).first(static_cast<size_t>(vertices.count)))
    softest = std::max(softest, compliance({&site, 1}, {&one, 1}, n));
  if (softest == 0.0) return 0.0;  // nothing of it is free to move
  return factor_ / (kMiddleCurvature * std::max(compliance(contact, x), kSmallestShare * softest));
}

void PairStiffness::assign(const SurfaceMesh& mesh, std::span<const Vec3> x, std::vector<Contact>& contacts) {
  for (Contact& contact : contacts) {
    const auto [entry, is_new] = frozen_.try_emplace(contact.key, 0.0);
    if (is_new) entry->second = natural(mesh, contact, x);
    contact.stiffness = entry->second * memory_.find(LoadMemory::code(contact));
  }
}

std::map<int64_t, double> PairStiffness::wanted(const std::vector<Contact>& contacts,
                                                std::span<const Vec3> forces) const {
  std::map<int64_t, double> wanted;
  for (const int64_t bodies : memory_.bodies) wanted[bodies] = 0.0;
  for (size_t c = 0; c < contacts.size(); ++c) {
    if (contacts[c].stiffness == 0.0) continue;
    const double natural = contacts[c].stiffness / memory_.find(LoadMemory::code(contacts[c]));
    double& largest = wanted[LoadMemory::code(contacts[c])];
    largest = std::max(largest, norm(forces[c]) / (kLoadedSlope * contacts[c].contact_distance * natural));
  }
  return wanted;
}

LoadMemory PairStiffness::end_step(const std::vector<Contact>& contacts, std::span<const Vec3> forces,
                                   double share) const {
  LoadMemory memory;
  for (const auto& [bodies, asked] : wanted(contacts, forces))
    memory.add(bodies, next_factor(memory_.find(bodies), asked, share));
  return memory;
}

LoadMemory PairStiffness::raised(const std::vector<Contact>& contacts, std::span<const Vec3> forces) const {
  LoadMemory memory;
  for (const auto& [bodies, asked] : wanted(contacts, forces)) {
    const double now = memory_.find(bodies);
    memory.add(bodies, std::clamp(asked, now, std::max(now, std::min(kRaise * now, kHighest))));
  }
  return memory;
}

}  // namespace stark
