// Scene: checks of the energies that users add.
#include <algorithm>
#include <cmath>

#include <stark/base/error.h>
#include <stark/sim/scene/scene.h>
#include <stark/sim/scene/validation.h>

namespace stark {

namespace {

std::string count_text(int64_t count, const char* what) {
  return std::to_string(count) + " " + what + (count == 1 ? "" : "s");
}

}  // namespace

int64_t EnergyDescription::element_count() const {
  int64_t count = points.empty() ? 0 : points.front().size();
  for (const PointSet& set : points)
    if (set.size() != 1) count = set.size();
  return count;
}

void Scene::check_points(const std::string& owner, const PointSet& points) const {
  const auto check_finite_points = [&] {
    for (const Vec3& p : points.local) check_finite(owner, "point", p, "m");
  };
  if (points.kind == PointKind::WorldPoints) return check_finite_points();
  if (points.kind == PointKind::Joined)
    throw InvalidArgument(owner +
                          ": points of several bodies: must be of one body; add one for each of them");
  const std::string where = owner + ": points of '" + name(points.body) + "'";
  const bool is_rigid = stark::is_rigid(kind(points.body));
  const auto check_vertex = [&,
                             count = static_cast<int32_t>(initial_positions(points.body).size())](int32_t v) {
    if (v < 0 || v >= count)
      throw InvalidArgument(where + ": vertex " + std::to_string(v) + ": must be in [0, " +
                            std::to_string(count) + "); give indices of vertices of the mesh");
  };
  const bool is_rod = has_nodes(kind(points.body));
  switch (points.kind) {
    case PointKind::Vertices:
      for (const int32_t v : points.vertices) check_vertex(v);
      break;
    case PointKind::BodyPoints:
    case PointKind::BodyDirections:
      if (is_rod)
        check_vertex(points.node);
      else if (!is_rigid)
        throw InvalidArgument(where +
                              ": only rigid bodies and nodes of rods have points and directions in their "
                              "frame; use "
                              "vertices, or points embedded in an element");
      check_finite_points();
      break;
    case PointKind::Embedded:
      if (is_rigid || is_rod)
        throw InvalidArgument(where +
                              ": points are embedded in cloth and solids only; use points in the "
                              "frame of the rigid body or of a node of the rod");
      if (points.weights.size() != points.supports.size())
        throw InvalidArgument(where + ": " + std::to_string(points.weights.size()) + " rows of weights for " +
                              count_text(points.size(), "point") + ": must be as many");
      for (size_t k = 0; k < points.supports.size(); ++k) {
        double sum = 0.0;
        for (int i = 0; i < 4; ++i) check_vertex(points.supports[k][i]), sum += points.weights[k][i];
        if (!(std::fabs(sum - 1.0) < 1e-9))
          throw InvalidArgument(where + ": the weights of point " + std::to_string(k) + " sum to " +
                                to_text(sum) + ": must sum to 1");
      }
      break;
    case PointKind::WorldPoints:
    case PointKind::Joined:
      break;
  }
}

EnergyId Scene::add_energy(EnergyDescription energy) {
  if (energy.name.empty()) {
    energy.name = energy_names_.next(energy.potential.name);
  } else if (energy_names_.contains(energy.name)) {
    throw InvalidArgument("energy '" + energy.name +
                          "': the name is taken: names of energies must be unique in a scene; choose another "
                          "or leave it out");
  }
  const std::string owner = "energy '" + energy.name + "'";
  if (!energy.potential.energy || static_cast<int>(energy.points.size()) != energy.potential.point_count)
    throw InvalidArgument(owner + ": " + count_text(energy.points.size(), "set") + " of points for " +
                          count_text(energy.potential.point_count, "point") + ": must be one for each point");
  const int64_t count = energy.element_count();
  for (const PointSet& set : energy.points) {
    if (set.kind != PointKind::Joined) check_points(owner, set);
    for (const PointSet& part : set.parts) check_points(owner, part);
    if (set.size() != 1 && set.size() != count)
      throw InvalidArgument(owner + ": sets of " + std::to_string(count) + " and of " +
                            std::to_string(set.size()) +
                            " points: must all have the same number of points, or one point");
  }
  if (count == 0)
    throw InvalidArgument(owner +
                          ": acts on 0 elements: must have at least one; check the selection of points");
  const std::vector<ParameterDeclaration> fields = parameters_of(energy.potential);
  std::vector<std::string> names;
  for (const ParameterDeclaration& field : fields) {
    names.push_back(field.name);
    const auto given = energy.values.find(field.name);
    if (given == energy.values.end())
      throw InvalidArgument(owner + ": '" + field.name + "' [" + field.unit + "] is missing: " + field.doc);
    check_values(owner, field, given->second, count);
  }
  for (const auto& [name, values] : energy.values)
    if (std::find(names.begin(), names.end(), name) == names.end())
      throw InvalidArgument(owner + ": unknown value '" + name + "'" + nearest_name_hint(name, names) +
                            ": must be an input of the formula; remove it");
  energy_names_.add(energy.name);
  energies_.push_back(std::move(energy));
  return {static_cast<int32_t>(energies_.size()) - 1};
}

const EnergyDescription& Scene::energy(EnergyId energy) const {
  if (energy.index < 0 || energy.index >= static_cast<int32_t>(energies_.size()))
    throw InvalidArgument("energy id " + std::to_string(energy.index) + ": must be in [0, " +
                          std::to_string(energies_.size()) +
                          ") for this scene; use the ids that add_energy returned");
  return energies_[energy.index];
}

}  // namespace stark
