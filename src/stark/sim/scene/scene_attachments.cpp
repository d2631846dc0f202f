// Scene: checks of attachments.
#include <algorithm>
#include <map>

#include <stark/base/error.h>
#include <stark/sim/scene/scene.h>
#include <stark/sim/scene/validation.h>

namespace stark {

namespace {

/// Twice the area over the longest edge squared, below which a patch has no normal to speak of.
constexpr double kThinnestPatch = 1e-6;

void check_is_points(const std::string& owner, const PointSet& points) {
  if (points.kind == PointKind::BodyDirections)
    throw InvalidArgument(owner + ": directions cannot be attached: must be points");
}

/// What a point follows: vertices of a body with their weights, or the frame of a rigid body or a node.
struct Support {
  int32_t body = -1;
  bool is_frame = false;
  std::map<int32_t, double> vertices{};  ///< of a frame: the node, -1 of a rigid body
  bool operator==(const Support&) const = default;
};

Support support_of(const PointSet& points, int64_t k, bool has_frames) {
  if (points.kind == PointKind::WorldPoints) return {};
  Support support{points.body.index, has_frames || points.kind == PointKind::BodyPoints};
  if (points.kind == PointKind::BodyPoints) support.vertices[points.node] = 1.0;
  if (points.kind == PointKind::Vertices) support.vertices[points.vertices[k]] = 1.0;
  for (size_t i = 0; points.kind == PointKind::Embedded && i < 4; ++i)
    if (points.weights[k][i] != 0.0) support.vertices[points.supports[k][i]] += points.weights[k][i];
  return support;
}

}  // namespace

void Scene::check_not_itself(const std::string& owner, const AttachmentDescription& attachment) const {
  const auto supports = [&](const PointSet& points, std::vector<Support>& out) {
    const bool has_frames = points.kind != PointKind::WorldPoints && has_nodes(kind(points.body));
    for (int64_t k = 0; k < points.size(); ++k) out.push_back(support_of(points, k, has_frames));
  };
  std::vector<Support> a, b;
  supports(attachment.a, a);
  for (const PointSet& points : attachment.b) supports(points, b);
  for (size_t pair = 0; pair < a.size(); ++pair) {
    if (a[pair].body < 0) continue;
    bool is_same = !b.empty() && a[pair] == b[pair];
    if (!attachment.patches.empty() && a[pair].body == attachment.patch_body.index && !a[pair].is_frame)
      is_same = std::ranges::all_of(a[pair].vertices, [&](const auto& entry) {
        return std::ranges::find(attachment.patches[pair], entry.first) != attachment.patches[pair].end();
      });
    if (!is_same) continue;
    const std::string what = a[pair].is_frame && a[pair].vertices.begin()->first < 0
                                 ? "one rigid body"
                                 : std::string(a[pair].is_frame ? "node " : "vertex ") +
                                       std::to_string(a[pair].vertices.begin()->first);
    throw InvalidArgument(owner + ": pair " + std::to_string(pair) + " attaches '" + name(attachment.a.body) +
                          "' to itself, at " + what +
                          ": must be points that can move against each other; leave the pair out");
  }
}

void Scene::check_patches(const std::string& owner, const AttachmentDescription& attachment) const {
  const BodyId body = attachment.patch_body;
  if (!has_points(kind(body)))
    throw InvalidArgument(owner + ": '" + name(body) + "' is a " + to_string(kind(body)) +
                          " body: patches belong to cloth and solids; give points of the body");
  const std::vector<Vec3> x = initial_positions(body);
  for (const Index3& patch : attachment.patches) {
    for (const int32_t v : patch)
      if (v < 0 || static_cast<size_t>(v) >= x.size())
        throw InvalidArgument(owner + ": patches of '" + name(body) + "': vertex " + std::to_string(v) +
                              ": must be in [0, " + std::to_string(x.size()) +
                              "); give indices of vertices of the mesh");
    const Vec3 &a = x[patch[0]], &b = x[patch[1]], &c = x[patch[2]];
    const double longest = std::max({norm(b - a), norm(c - b), norm(a - c)});
    if (!(norm(cross(b - a, c - a)) > kThinnestPatch * longest * longest))
      throw InvalidArgument(owner + ": the patch (" + std::to_string(patch[0]) + ", " +
                            std::to_string(patch[1]) + ", " + std::to_string(patch[2]) + ") of '" +
                            name(body) +
                            "' has no area at time 0: its vertices must not be on a line; choose others");
  }
}

AttachmentId Scene::add_attachment(AttachmentDescription attachment) {
  if (attachment.name.empty()) {
    attachment.name = attachment_names_.next("attachment");
  } else if (attachment_names_.contains(attachment.name)) {
    throw InvalidArgument("attachment '" + attachment.name +
                          "': the name is taken: names of attachments must be unique in a scene; choose "
                          "another or leave it out");
  }
  const std::string owner = "attachment '" + attachment.name + "'";
  check_is_points(owner, attachment.a);
  check_points(owner, attachment.a);
  if (attachment.size() == 0)
    throw InvalidArgument(owner + ": has 0 points: must have at least one; check the selection of points");
  int64_t carriers = static_cast<int64_t>(attachment.patches.size());
  bool has_body = attachment.a.kind != PointKind::WorldPoints || !attachment.patches.empty();
  if (!attachment.patches.empty()) check_patches(owner, attachment);
  for (const PointSet& points : attachment.b) {
    check_is_points(owner, points);
    check_points(owner, points);
    carriers += points.size();
    has_body = has_body || points.kind != PointKind::WorldPoints;
  }
  if (carriers != attachment.size() || (!attachment.patches.empty() && !attachment.b.empty()))
    throw InvalidArgument(owner + ": " + std::to_string(attachment.size()) + " points on " +
                          std::to_string(carriers) +
                          " points or patches: must be as many, of one of the two kinds");
  check_not_itself(owner, attachment);
  if (!has_body)
    throw InvalidArgument(owner + ": both sides are of the world: at least one must be of a body");
  if (!(attachment.break_force > 0.0))
    throw InvalidArgument(owner + ": break_force = " + quantity_text(attachment.break_force, "N") +
                          ": must be > 0; leave it out for pairs that do not break");
  attachment_names_.add(attachment.name);
  attachments_.push_back(std::move(attachment));
  return {static_cast<int32_t>(attachments_.size()) - 1};
}

const AttachmentDescription& Scene::attachment(AttachmentId attachment) const {
  if (attachment.index < 0 || attachment.index >= static_cast<int32_t>(attachments_.size()))
    throw InvalidArgument("attachment id " + std::to_string(attachment.index) + ": must be in [0, " +
                          std::to_string(attachments_.size()) +
                          ") for this scene; use the ids that add_attachment returned");
  return attachments_[attachment.index];
}

}  // namespace stark
