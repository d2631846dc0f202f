// Layers of a model: masses on the points of their bodies, energies of skins; frames, segments and seams of
// fibres.
// A node of a fibre is a vertex of its body and a frame that turns only: the frame lives among the rigid
// bodies of the state with a prescribed place, which nothing asks for.
#include <algorithm>

#include <stark/geometry/polyline.h>
#include <stark/sim/model/model_builder.h>
#include <stark/sim/scene/layers.h>
#include <stark/sim/scene/lumped_mass.h>

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
    double& rate = model.point_damping_[first + v];
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
        node.is_frame = true;
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
  for (size_t f = 0; f < scene.fibres().size(); ++f) {
    const FibresDescription& fibres = scene.fibres()[f];
    FibreStencils& stencils = fibre_stencils.emplace_back();
    if (fibres.bending) {
      int32_t frame = model.fibres_[f].first_frame;
      const std::vector<PathFrames> frames = path_frames(scene, fibres);
      for (size_t p = 0; p < frames.size(); ++p) {
        add_fibre_path(fibres, fibres.paths[p], frames[p], frame, stencils);
        frame += static_cast<int32_t>(frames[p].rest.size());
      }
    } else {
      const int32_t first = model.bodies_[fibres.body.index].first_site;
      for (const auto& path : fibres.paths)
        for (size_t k = 0; k + 1 < path.size(); ++k)
          for (const int32_t v : {path[k], path[k + 1]}) stencils.segments.push_back(first + v);
    }
  }
}

void Model::Builder::add_fibre_path(const FibresDescription& fibres, const std::vector<int32_t>& path,
                                    const PathFrames& frames, int32_t first_frame, FibreStencils& out) {
  const int32_t first = model.bodies_[fibres.body.index].first_site;
  const std::vector<Vec3>& X = scene.rest_vertices(fibres.body);
  const size_t nodes = frames.rest.size();
  const auto add_rest = [&](const Mat3& frame) {
    for (int k = 0; k < 3; ++k) model.rest_positions_.push_back(frame.column(k));
  };
  std::vector<int32_t> axes;
  for (size_t n = 0; n < nodes; ++n) {
    add_axis_sites(first_frame + static_cast<int32_t>(n));
    add_rest(frames.rest[n]);
    axes.push_back(axis_sites[first_frame + n]);
    out.seams.insert(out.seams.end(),
                     {first + path[n], first + frames.neighbours[n], axes.back(), axes.back() + 1});
    out.reaches.push_back(model.rigid_masses_[first_frame + n].reach);
  }
  for (size_t k = 0; k + 1 < path.size(); ++k) {
    std::array<int32_t, 2> of_ends{axes[k], axes[(k + 1) % nodes]};
    if (fibres.rest_shape == RestShape::Straight) {
      // Axes that move the same, at rest in the frame of the edge.
      const Mat3 rest = polyline_frames(std::vector<Vec3>{X[path[k]], X[path[k + 1]]})[0];
      for (size_t end = 0; end < 2; ++end) {
        of_ends[end] = static_cast<int32_t>(sites.size());
        for (int i = 0; i < 3; ++i) sites.push_back(Site(sites[axes[(k + end) % nodes] + i]));
        add_rest(rest);
      }
    }
    out.segments.insert(out.segments.end(), {first + path[k], first + path[k + 1]});
    for (const int32_t axis : of_ends) out.segments.insert(out.segments.end(), {axis, axis + 1, axis + 2});
  }
}

void Model::Builder::add_layer_energies() {
  for (const SkinDescription& skin : scene.skins())
    add_shell_energies(sheet_of(scene, skin), model.bodies_[skin.body.index], skin.name);
  for (size_t f = 0; f < scene.fibres().size(); ++f) {
    const ElasticEnergy elastic = elastic_energy(scene.fibres()[f]);
    const FibreStencils& stencils = fibre_stencils[f];
    add_batch(elastic.definition, stencils.segments, scene.fibres()[f].name, elastic.values);
    if (stencils.seams.empty()) continue;
    PotentialBatch& seams = add_batch(models::fibre_seam(), stencils.seams, scene.fibres()[f].name);
    const double twisting = section_of(scene.fibres()[f].material).torsional_stiffness;
    for (int64_t n = 0; n < seams.size(); ++n) seams.set("stiffness", n, twisting / stencils.reaches[n]);
  }
}

void Model::Builder::set_initial_fibres() {
  State& state = model.initial_state_;
  for (const FibresDescription& fibres : scene.fibres()) {
    if (!fibres.bending) continue;
    const Vec3 turning = scene.visit(fibres.body, [](const auto& body) { return body.angular_velocity; });
    for (const PathFrames& frames : path_frames(scene, fibres))
      for (const Mat3& frame : frames.initial) {
        state.body_position.push_back({});
        state.body_velocity.push_back({});
        state.body_rotation.push_back(frame);
        state.body_angular_velocity.push_back(turning);
      }
  }
}

}  // namespace stark
