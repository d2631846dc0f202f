// Scene: checks of layers.
#include <algorithm>
#include <set>

#include <stark/base/error.h>
#include <stark/geometry/topology.h>
#include <stark/sim/scene/body_checks.h>
#include <stark/sim/scene/layers.h>
#include <stark/sim/scene/material_fields.h>

namespace stark {

namespace {

std::string path_text(size_t k) { return "path " + std::to_string(k); }

/// Vertices of the paths: as many as needed, in range, no edge twice.
void check_paths(const std::string& owner, const FibresDescription& fibres, size_t vertex_count) {
  if (fibres.paths.empty())
    throw InvalidArgument(owner + ": has 0 paths: must have at least one; check the selection of edges");
  std::set<Index2> known;
  for (size_t k = 0; k < fibres.paths.size(); ++k) {
    const std::vector<int32_t>& path = fibres.paths[k];
    if (path.size() < 2)
      throw InvalidArgument(owner + ": " + path_text(k) + " has " + std::to_string(path.size()) +
                            " vertices: must have at least 2, the ends of an edge");
    for (const int32_t v : path)
      if (v < 0 || static_cast<size_t>(v) >= vertex_count)
        throw InvalidArgument(owner + ": " + path_text(k) + ": vertex " + std::to_string(v) +
                              ": must be in [0, " + std::to_string(vertex_count) +
                              "); give indices of vertices of the body");
    for (size_t i = 0; i + 1 < path.size(); ++i) {
      const Index2 edge{std::min(path[i], path[i + 1]), std::max(path[i], path[i + 1])};
      if (edge[0] == edge[1])
        throw InvalidArgument(owner + ": " + path_text(k) + ": edge " + std::to_string(i) + " joins vertex " +
                              std::to_string(edge[0]) +
                              " with itself: its vertices must be different; remove one");
      if (!known.insert(edge).second)
        throw InvalidArgument(owner + ": the edge of the vertices " + std::to_string(edge[0]) + " and " +
                              std::to_string(edge[1]) + " is there twice, the second time in " +
                              path_text(k) +
                              ": must be there once; for a thicker fibre change the section, for two add "
                              "fibres twice");
    }
  }
}

void check_shape(const std::string& owner, const FibresDescription& fibres, std::span<const Vec3> vertices,
                 const std::string& when) {
  for (size_t k = 0; k < fibres.paths.size(); ++k) {
    const std::vector<Vec3> points = path_points(fibres.paths[k], vertices);
    check_edge_lengths(owner, path_text(k) + when, points);
    if (!fibres.bending) continue;
    check_polyline(owner, path_text(k) + when, points);
    if (fibres.normal && when.empty()) check_normal(owner, *fibres.normal, points);
  }
}

void check_has_frames(const std::string& owner, const FibresDescription& fibres) {
  if (fibres.bending) return;
  if (fibres.rest_shape != RestShape::Mesh || fibres.normal)
    throw InvalidArgument(owner + ": " + (fibres.normal ? "normal" : "rest_shape = straight") +
                          " is given: must be left out with bending = false, as only stretch is resisted");
}

void check_color(const std::string& owner, const std::optional<Color>& color) {
  if (!color) return;
  for (const double channel : *color)
    check_number(owner, "color channel", channel, "1", closed_interval(0.0, 1.0),
                 "give red, green, blue in [0, 1]");
}

}  // namespace

std::string Scene::name_layer(const std::string& kind, BodyId body, std::string& layer) {
  const std::string of_body = " of " + owner_text(this->kind(body), name(body));
  if (!has_points(this->kind(body)))
    throw InvalidArgument(kind + of_body +
                          ": the body must be a cloth or a solid, whose vertices a layer shares; use an "
                          "attachment");
  if (const SolidMesh* mesh = solid_mesh(body); mesh && mesh->is_embedded())
    throw InvalidArgument(
        kind + of_body +
        ": its surface is embedded and follows the nodes of a lattice: the body must have a "
        "mesh of its own for layers; use tetrahedra, or a cloth and an attachment");
  const bool is_given = !layer.empty();
  if (!is_given) layer = free_name(name(body) + "_" + kind);
  const std::string owner = kind + " '" + layer + "'" + of_body;
  if (is_given && body_names_.contains(layer))
    throw InvalidArgument(owner +
                          ": the name is taken: names of bodies and layers must be unique in a scene; "
                          "choose another or leave it out");
  return owner;
}

SkinId Scene::add_skin(SkinDescription skin) {
  const std::string owner = name_layer("skin", skin.body, skin.name);
  std::vector<std::string> warnings;
  keep_largest_bending(skin.material, skin.fields);
  validate(skin.material, owner);
  check_color(owner, skin.color);
  if (skin.triangles.empty()) skin.triangles = surface_triangles(skin.body);
  const ClothDescription sheet = sheet_of(*this, skin);
  check_layer_triangles(owner, sheet.mesh, warnings);
  warn_about_free_directions(owner, sheet.mesh, skin.material, warnings);
  check_fields(owner, sheet);
  warnings_.insert(warnings_.end(), warnings.begin(), warnings.end());
  body_names_.add(skin.name);
  layer_names_.add(skin.name);
  skins_.push_back(std::move(skin));
  return {static_cast<int32_t>(skins_.size()) - 1};
}

FibresId Scene::add_fibres(FibresDescription fibres) {
  const std::string owner = name_layer("fibres", fibres.body, fibres.name);
  validate(fibres.material, owner);
  check_color(owner, fibres.color);
  check_paths(owner, fibres, rest_vertices(fibres.body).size());
  check_has_frames(owner, fibres);
  check_shape(owner, fibres, rest_vertices(fibres.body), "");
  check_shape(owner, fibres, initial_positions(fibres.body), " at time 0");
  check_fields(owner, fibres);
  body_names_.add(fibres.name);
  layer_names_.add(fibres.name);
  fibres_.push_back(std::move(fibres));
  return {static_cast<int32_t>(fibres_.size()) - 1};
}

const SkinDescription& Scene::skin(SkinId skin) const {
  if (skin.index < 0 || skin.index >= static_cast<int32_t>(skins_.size()))
    throw InvalidArgument("skin id " + std::to_string(skin.index) + ": must be in [0, " +
                          std::to_string(skins_.size()) +
                          ") for this scene; use the ids that add_skin returned");
  return skins_[skin.index];
}

const FibresDescription& Scene::fibres(FibresId fibres) const {
  if (fibres.index < 0 || fibres.index >= static_cast<int32_t>(fibres_.size()))
    throw InvalidArgument("fibres id " + std::to_string(fibres.index) + ": must be in [0, " +
                          std::to_string(fibres_.size()) +
                          ") for this scene; use the ids that add_fibres returned");
  return fibres_[fibres.index];
}

}  // namespace stark
