// The user's energies of a model: sites of their points, batches with their values.
#include <algorithm>

#include <stark/sim/model/model_builder.h>

namespace stark {

int32_t Model::Builder::add_combined_row(const ModelBody& body, const Index4& vertices,
                                         const std::array<double, 4>& weights) {
  std::map<int32_t, double> sum;
  for (int i = 0; i < 4; ++i) {
    const int32_t p = body.first_site + vertices[i];
    if (!follows(p)) {
      sum[p] += weights[i];
      continue;
    }
    const std::span<const int32_t> nodes = embedded.points_of(embedded.support[sites[p].index]);
    const std::span<const double> of_nodes = embedded.weights_of(sites[p].index);
    for (size_t k = 0; k < nodes.size(); ++k) sum[nodes[k]] += weights[i] * of_nodes[k];
  }
  std::vector<int32_t> support;
  std::vector<double> row;
  for (const auto& [p, weight] : sum) {
    support.push_back(p);
    row.push_back(weight);
  }
  return embedded.add_row(embedded.add_support(support), row);
}

int32_t Model::Builder::add_site(const Site& site, const Vec3& rest) {
  sites.push_back(site);
  model.rest_positions_.push_back(rest);
  return static_cast<int32_t>(sites.size()) - 1;
}

int32_t Model::Builder::add_embedded_site(const ModelBody& body, const Index4& vertices,
                                          const std::array<double, 4>& weights) {
  Vec3 rest;
  for (int i = 0; i < 4; ++i) rest += model.rest_positions_[body.first_site + vertices[i]] * weights[i];
  Site site{.kind = SiteKind::Barycentric, .index = 0, .local = {}, .points = {}, .weights = {}};
  if (std::ranges::any_of(vertices, [&](int32_t v) { return follows(body.first_site + v); })) {
    site.kind = SiteKind::Embedded;
    site.index = add_combined_row(body, vertices, weights);
    return add_site(site, rest);
  }
  // Points come first among the sites.
  for (int i = 0; i < 4; ++i) site.points[i] = body.first_site + vertices[i];
  site.weights = weights;
  return add_site(site, rest);
}

std::vector<int32_t> Model::Builder::add_point_sites(const PointSet& points) {
  std::vector<int32_t> result;
  const auto add = [&](SiteKind kind, int32_t index, const Vec3& local, const Vec3& rest) {
    const Site site{.kind = kind, .index = index, .local = local, .points = {}, .weights = {}};
    result.push_back(add_site(site, rest));
  };
  if (points.kind == PointKind::WorldPoints) {
    for (const Vec3& p : points.local) add(SiteKind::World, 0, p, p);
    return result;
  }
  if (points.kind == PointKind::Joined) {
    for (const PointSet& part : points.parts) {
      const std::vector<int32_t> of_part = add_point_sites(part);
      result.insert(result.end(), of_part.begin(), of_part.end());
    }
    return result;
  }
  const ModelBody& body = model.bodies_[points.body.index];
  const int32_t moving = body.rigid_index + std::max(points.node, 0);
  const Mat3 to_body = transpose(body.axes);
  if (points.kind == PointKind::Vertices)
    for (const int32_t v : points.vertices) result.push_back(body.first_site + v);
  else if (points.kind == PointKind::BodyPoints)
    for (const Vec3& p : points.local) add(SiteKind::RigidPoint, moving, to_body * (p - body.centre), p);
  else if (points.kind == PointKind::BodyDirections)
    for (const Vec3& d : points.local) add(SiteKind::RigidDirection, moving, to_body * d, d);
  else
    for (size_t k = 0; k < points.supports.size(); ++k)
      result.push_back(add_embedded_site(body, points.supports[k], points.weights[k]));
  return result;
}

void Model::Builder::add_energy_sites() {
  for (const EnergyDescription& energy : scene.energies()) {
    std::vector<std::vector<int32_t>> columns;
    for (const PointSet& set : energy.points) columns.push_back(add_point_sites(set));
    std::vector<int32_t>& stencils = energy_stencils.emplace_back();
    for (int64_t e = 0; e < energy.element_count(); ++e)
      for (const std::vector<int32_t>& column : columns)
        stencils.push_back(column[column.size() == 1 ? 0 : e]);
  }
}

void Model::Builder::add_energies() {
  for (size_t k = 0; k < scene.energies().size(); ++k) {
    const EnergyDescription& energy = scene.energies()[k];
    add_batch(energy.potential, energy_stencils[k], energy.name, energy.values);
    model.energy_batches_.push_back(static_cast<int32_t>(energies.batches.size()) - 1);
  }
}

}  // namespace stark
