#include <stark/sim/step/element_strain.h>

#include <algorithm>
#include <cmath>
#include <limits>
#include <queue>
#include <utility>

#include <stark/sim/scene/body_checks.h>

namespace stark {

namespace {

/// Strains below it are ordinary.
constexpr double kOrdinaryStrain = 0.1;

/// Pins from which lengths are measured: each costs a search through all edges of the body.
constexpr int kPinSamples = 8;

double area(std::span<const Vec3> x, std::span<const int32_t> t) {
  return 0.5 * norm(cross(x[t[1]] - x[t[0]], x[t[2]] - x[t[0]]));
}

/// Shortest ways along edges from a vertex to all others [m].
std::vector<double> lengths_from(int32_t start,
                                 const std::vector<std::vector<std::pair<int32_t, double>>>& next) {
  std::vector<double> lengths(next.size(), std::numeric_limits<double>::infinity());
  using Entry = std::pair<double, int32_t>;
  std::priority_queue<Entry, std::vector<Entry>, std::greater<>> open;
  lengths[start] = 0.0;
  open.emplace(0.0, start);
  while (!open.empty()) {
    const auto [length, v] = open.top();
    open.pop();
    if (length > lengths[v]) continue;
    for (const auto& [w, edge] : next[v])
      if (length + edge < lengths[w]) {
        lengths[w] = length + edge;
        open.emplace(lengths[w], w);
      }
  }
  return lengths;
}

/// Some of the pins that lie far apart at x: each the farthest from those before it.
std::vector<int32_t> spread(std::span<const int32_t> pins, std::span<const Vec3> x) {
  std::vector<int32_t> chosen{pins[0]};
  std::vector<double> nearest(pins.size(), std::numeric_limits<double>::infinity());
  while (chosen.size() < std::min<size_t>(pins.size(), kPinSamples)) {
    size_t farthest = 0;
    for (size_t k = 0; k < pins.size(); ++k) {
      nearest[k] = std::min(nearest[k], norm(x[pins[k]] - x[chosen.back()]));
      if (nearest[k] > nearest[farthest]) farthest = k;
    }
    chosen.push_back(pins[farthest]);
  }
  return chosen;
}

}  // namespace

double severity(const StrainedElement& element) {
  if (!(element.size > 0.0) || !(element.stretch > 0.0)) return std::numeric_limits<double>::infinity();
  return std::max(std::fabs(std::log(element.size)), std::fabs(std::log(element.stretch)));
}

std::vector<StrainedElement> find_strained_elements(const Scene& scene, BodyId body, std::span<const Vec3> x,
                                                    size_t count) {
  const BodyElements elements = elements_of(scene, body);
  if (elements.count() == 0) return {};
  const std::span<const Vec3> X = scene.rest_vertices(body);
  const SolidMesh* rest = scene.solid_mesh(body);
  SolidMesh deformed;
  if (rest) deformed = {std::vector<Vec3>(x.begin(), x.end()), rest->type, rest->elements};
  const std::string owner = owner_text(scene.kind(body), scene.name(body));
  std::vector<char> pinned(X.size(), 0);
  for (const int32_t v : scene.pins(body).vertices) pinned[v] = 1;

  std::vector<StrainedElement> found;
  for (size_t e = 0; e < elements.count(); ++e) {
    const auto nodes = elements.at(e);
    const auto id = static_cast<int64_t>(e);
    StrainedElement element{.element = id};
    for (const auto& [i, j] : elements.edges) {
      const double stretch = norm(x[nodes[j]] - x[nodes[i]]) / norm(X[nodes[j]] - X[nodes[i]]);
      if (!(std::fabs(std::log(stretch)) <= std::fabs(std::log(element.stretch)))) element.stretch = stretch;
    }
    element.size = rest                  ? smallest_jacobian(deformed, id) / smallest_jacobian(*rest, id)
                   : elements.width == 3 ? area(x, nodes) / area(X, nodes)
                                         : element.stretch;
    if (severity(element) < kOrdinaryStrain) continue;
    if (found.size() == count && severity(element) <= severity(found.back())) continue;
    element.at = {owner, {nodes.begin(), nodes.end()}};
    element.is_prescribed = std::ranges::all_of(nodes, [&](int32_t v) { return pinned[v] != 0; });
    // Kept sorted, the worst first; of equal ones the first.
    const auto place = std::ranges::upper_bound(found, severity(element), std::greater<>{}, severity);
    found.insert(place, std::move(element));
    if (found.size() > count) found.pop_back();
  }
  return found;
}

std::optional<PinPair> find_stretched_pins(const Scene& scene, BodyId body, std::span<const Vec3> x) {
  const std::vector<int32_t>& pins = scene.pins(body).vertices;
  if (pins.size() < 2) return {};
  const std::span<const Vec3> X = scene.rest_vertices(body);
  const BodyElements elements = elements_of(scene, body);
  std::vector<std::vector<std::pair<int32_t, double>>> next(X.size());
  for (size_t e = 0; e < elements.count(); ++e)
    for (const auto& [i, j] : elements.edges) {
      const int32_t v = elements.at(e)[i], w = elements.at(e)[j];
      next[v].emplace_back(w, norm(X[w] - X[v]));
      next[w].emplace_back(v, norm(X[w] - X[v]));
    }
  std::optional<PinPair> worst;
  for (const int32_t from : spread(pins, x)) {
    const std::vector<double> lengths = lengths_from(from, next);
    for (const int32_t to : pins) {
      if (to == from || !std::isfinite(lengths[to])) continue;
      PinPair pair{.pins = {owner_text(scene.kind(body), scene.name(body)), {from, to}},
                   .distance = norm(x[to] - x[from]),
                   .length = lengths[to]};
      if (!worst || pair.stretch() > worst->stretch()) worst = std::move(pair);
    }
  }
  return worst;
}

}  // namespace stark
