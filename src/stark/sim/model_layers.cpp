// Layers of a model: masses on the points of their bodies, energies of skins, frames and segments of fibres.
// A node of a fibre is a vertex of its body and a frame that turns only: the frame lives among the rigid
// bodies of the state with a prescribed place, which nothing asks for.
#include <algorithm>

#include <stark/geometry/polyline.h>
#include <stark/sim/layers.h>
#include <stark/sim/lumped_mass.h>
#include <stark/sim/model_builder.h>

namespace stark {

void Model::Builder::add_layer_masses() {
  for (const SkinDescription& skin : scene.skins())
    add_point_masses(skin.body, lumped_masses(scene, skin), skin.material.mass_damping);
  for (const FibresDescription& fibres : scene.fibres())
    add_point_masses(fibres.body, lumped_masses(scene, fibres), fibres.material.mass_damping);
}

void Model::Builder::add_point_masses(BodyId body, std::span<const double> masses, double damping) {
  const int32_t first = model.bodies_[body.index].first_site;
  for (size_t v = 0; v < masses.size(); ++v) {
    if (masses[v] == 0.0) continue;
    double& mass = model.point_masses_[first + v];
    double& rate = point_damping[first + v];
    rate = (mass * rate + masses[v] * damping) / (mass + masses[v]);  // forces of damping add up
    mass += masses[v];
  }
}

void Model::Builder::add_fibre_frames() {
  for (const FibresDescription& fibres : scene.fibres()) {
    const int32_t first = static_cast<int32_t>(model.rigid_masses_.size());
    const std::vector<double> lengths = fibre_lengths(scene, fibres), masses = fibre_masses(scene, fibres);
    const RodSection section = section_of(fibres.material);
    size_t e = 0;
    for (const auto& path : fibres.paths) {
      if (!fibres.bending) break;
      std::vector<RigidMass> nodes(node_count(path));
      std::vector<double> node_masses(nodes.size(), 0.0);
      for (size_t k = 0; k + 1 < path.size(); ++k, ++e)
        for (const size_t n : {k, (k + 1) % nodes.size()}) {
          node_masses[n] += 0.5 * masses[e];
          for (int i = 0; i < 2; ++i)
            nodes[n].second_moments[i] += 0.5 * masses[e] * section.second_moments[i] / section.mass;
          nodes[n].reach = std::max(nodes[n].reach, lengths[e]);
        }
      for (size_t n = 0; n < nodes.size(); ++n) {
        RigidMass& node = nodes[n];
        const Vec3& s = node.second_moments;
        node.moments = {s.y, s.x, s.x + s.y};
        node.resistance = node_masses[n] * node.reach * node.reach;  // as of rods
        node.angular_damping = fibres.material.mass_damping;
        model.rigid_masses_.push_back(node);
        body_prescribed.push_back(true);
        rotation_prescribed.push_back(false);
      }
    }
    model.fibres_.push_back({first, static_cast<int32_t>(model.rigid_masses_.size()) - first});
  }
}

void Model::Builder::add_fibre_sites() {
  fibre_stencils.resize(scene.fibres().size());
  for (size_t f = 0; f < scene.fibres().size(); ++f) {
    const FibresDescription& fibres = scene.fibres()[f];
    int32_t frame = model.fibres_[f].first_frame;
    for (const auto& path : fibres.paths) {
      if (!fibres.bending) {
        const int32_t first = model.bodies_[fibres.body.index].first_site;
        for (size_t k = 0; k + 1 < path.size(); ++k)
          fibre_stencils[f].insert(fibre_stencils[f].end(), {first + path[k], first + path[k + 1]});
        continue;
      }
      add_fibre_path(fibres, path, frame, fibre_stencils[f]);
      frame += static_cast<int32_t>(node_count(path));
    }
  }
}

void Model::Builder::add_fibre_path(const FibresDescription& fibres, const std::vector<int32_t>& path,
                                    int32_t first_frame, std::vector<int32_t>& stencils) {
  const int32_t nodes = static_cast<int32_t>(node_count(path));
  const int32_t first_site = model.bodies_[fibres.body.index].first_site;
  const std::vector<Mat3> rest = path_frames(scene, fibres, path).rest;
  const auto add_axes = [&](int32_t node, const Mat3& rest_frame) {
    const int32_t known = axis_sites[first_frame + node];
    add_axis_sites(first_frame + node);
    if (known >= 0) axis_sites[first_frame + node] = known;  // inertia acts on the first ones
    for (int k = 0; k < 3; ++k) model.rest_positions_.push_back(rest_frame.column(k));
    return static_cast<int32_t>(sites.size()) - 3;
  };
  // Axes of their own for each segment: the rest frames of a straight one are those of its edge.
  for (size_t k = 0; k + 1 < path.size(); ++k) {
    const std::array<int32_t, 2> ends{static_cast<int32_t>(k), static_cast<int32_t>(k + 1) % nodes};
    std::array<Mat3, 2> frames{rest[ends[0]], rest[ends[1]]};
    if (fibres.rest_shape == RestShape::Straight) {
      const std::vector<Vec3>& X = scene.rest_vertices(fibres.body);
      frames.fill(polyline_frames(std::vector<Vec3>{X[path[k]], X[path[k + 1]]})[0]);
    }
    stencils.insert(stencils.end(), {first_site + path[k], first_site + path[k + 1]});
    for (int end = 0; end < 2; ++end) {
      const int32_t axes = add_axes(ends[end], frames[end]);
      stencils.insert(stencils.end(), {axes, axes + 1, axes + 2});
    }
  }
}

void Model::Builder::add_layer_energies() {
  for (const SkinDescription& skin : scene.skins())
    add_shell_energies(sheet_of(scene, skin), model.bodies_[skin.body.index], skin.name);
  for (size_t f = 0; f < scene.fibres().size(); ++f) {
    const ElasticEnergy elastic = elastic_energy(scene.fibres()[f]);
    add_batch(elastic.definition, fibre_stencils[f], scene.fibres()[f].name, elastic.values);
  }
}

void Model::Builder::set_initial_fibres() {
  State& state = model.initial_state_;
  for (const FibresDescription& fibres : scene.fibres()) {
    if (!fibres.bending) continue;
    const Mat3 turning =
        skew(scene.kind(fibres.body) == BodyKind::Cloth ? scene.cloth(fibres.body).angular_velocity
                                                        : scene.solid(fibres.body).angular_velocity);
    for (const auto& path : fibres.paths)
      for (const Mat3& frame : path_frames(scene, fibres, path).initial) {
        state.body_position.push_back({});
        state.body_velocity.push_back({});
        state.body_rotation.push_back(frame);
        state.body_rotation_rate.push_back(turning * frame);
      }
  }
}

}  // namespace stark
