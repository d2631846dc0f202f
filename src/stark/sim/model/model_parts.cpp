// What a model was made of, part by part: names and hashes that tell whether a checkpoint is of the same
// scene, and if not, what differs. Phase: model building.
#include <algorithm>
#include <cstring>
#include <span>
#include <string>

#include <stark/mechanics/total_energy.h>
#include <stark/sim/model/model_builder.h>

namespace stark {

namespace {

/// Eight bytes at a time: one at a time, as Hash64 does, is felt when models of large meshes are built. Each
/// round is a bijection of the hash and of the word.
uint64_t hash_words(const void* data, size_t size) {
  const auto* bytes = static_cast<const unsigned char*>(data);
  uint64_t hash = size;
  for (size_t i = 0; i < size; i += sizeof(uint64_t)) {
    uint64_t word = 0;
    std::memcpy(&word, bytes + i, std::min(sizeof(word), size - i));
    hash = (hash ^ word) * 0x9e3779b97f4a7c15ull;
    hash ^= hash >> 32;
  }
  return hash;
}

template <typename T>
void append_all(Hash64& hash, std::span<const T> values) {
  hash.append(hash_words(values.data(), values.size_bytes()));
}
template <typename T>
void append_all(Hash64& hash, const std::vector<T>& values) {
  append_all(hash, std::span<const T>(values));
}

void append_mass(Hash64& hash, const RigidMass& mass) {
  hash.append(mass.mass);
  hash.append(mass.moments);
  hash.append(mass.second_moments);
  hash.append(mass.linear_damping);
  hash.append(mass.angular_damping);
}

void append_pair(Hash64& hash, int32_t a, int32_t b) {
  hash.append(a);
  hash.append(b);
}

void append_friction(Hash64& hash, const FrictionCoefficient& coefficient) {
  hash.append(coefficient.sticking);
  hash.append(coefficient.sliding);
  if (!coefficient.is_anisotropic()) return;
  hash.append(coefficient.along);
  hash.append(coefficient.across);
  hash.append(coefficient.frame);
}

}  // namespace

void Model::Builder::add_part(const std::string& name, bool is_structure, const Hash64& hash) {
  const auto [entry, is_new] = part_places.try_emplace(name, model.parts_.size());
  if (is_new) return model.parts_.push_back({name, is_structure, hash.value()});
  Hash64 both;  // joints of one kind between frames of several kinds are one part
  both.append(model.parts_[entry->second].hash);
  both.append(hash.value());
  model.parts_[entry->second].hash = both.value();
}

void Model::Builder::append_places(Hash64& hash, std::span<const int32_t> stencils) const {
  for (const int32_t id : stencils) {
    const Site& site = model.map_.site(id);
    hash.append(site.kind);
    hash.append(site.index);
    if (site.kind == SiteKind::Point) continue;
    hash.append(site.local);
    if (site.kind == SiteKind::Barycentric) hash.append(site.points), hash.append(site.weights);
    if (site.kind != SiteKind::Embedded) continue;
    append_all(hash, model.map_.support(id).points);
    append_all(hash, model.map_.support(id).weights);
  }
}

void Model::Builder::list_bodies() {
  for (int32_t i = 0; i < scene.body_count(); ++i) {
    const BodyId id{i};
    const ModelBody& body = model.bodies_[i];
    const std::string name = to_string(body.kind) + " '" + scene.name(id) + "'";
    Hash64 structure, shape, place, mass;
    structure.append(body.kind);
    structure.append(scene.motion(id));
    structure.append(body.site_count);
    append_all(structure, body.triangles);
    append_all(structure, body.edges);
    append_all(structure, body.pins);
    append_all(structure, body.clamped);
    const std::span<const Vec3> rest = model.rest_positions_;
    append_all(shape, rest.subspan(body.first_site, body.site_count));
    if (scene.motion(id) == Motion::Fixed) {
      place.append(model.initial_state_.body_position[body.rigid_index]);
      place.append(model.initial_state_.body_rotation[body.rigid_index]);
    }
    mass.append(body.centre);
    mass.append(body.axes);
    if (!has_points(body.kind)) {
      for (int32_t b = 0; b < body.rigid_count(); ++b)
        append_mass(mass, model.rigid_masses_[body.rigid_index + b]);
    } else {
      const std::span<const double> masses = model.point_masses_;
      append_all(mass, masses.subspan(body.first_site, body.site_count));
    }
    add_part("kind, motion, topology or pins of " + name, true, structure);
    add_part("rest shape of " + name, false, shape);
    add_part("place of " + name, false, place);
    add_part("mass of " + name, false, mass);
  }
}

void Model::Builder::list_batch(const std::string& name, const PotentialBatch& batch,
                                std::span<const int32_t> stencils) {
  Hash64 formula, points, values;
  formula.append(batch.potential().kernel().fingerprint());
  if (const TotalEnergy* totals = batch.potential().totals()) formula.append(totals->fingerprint());
  append_places(points, stencils);
  append_all(values, batch.element_values());
  append_all(values, batch.uniform_values());
  add_part("formula of " + name, false, formula);
  add_part("points of " + name, false, points);
  add_part("values of " + name, false, values);
}

void Model::Builder::list_energies() {
  const auto title = [](const std::string& law, const std::string& body) {
    return "the energy '" + law + "'" + (body.empty() ? "" : " of '" + body + "'");
  };
  std::vector<std::string> names(energies.batches.size());
  for (size_t b = 0; b < names.size(); ++b)
    names[b] = title(energies.batches[b].batch.potential().name(), energies.batches[b].owner);
  for (size_t e = 0; e < scene.energies().size(); ++e)
    names[model.energy_batches_[e]] = "the energy '" + scene.energies()[e].name + "'";
  for (size_t b = 0; b < names.size(); ++b) {
    const PotentialBatch& batch = energies.batches[b].batch;
    list_batch(names[b], batch, batch.stencils());
  }
  for (const ModelQuadrature& elements : energies.quadrature) {
    const std::string name = title(elements.batch.law().potential().name(), elements.body);
    // The stencils of the law are rows of deformation gradients, not sites.
    list_batch(name, elements.batch.law(), elements.batch.stencils());
  }
  for (const ConstraintGroup& group : energies.constraints.groups()) {
    const std::string name = "joints, actuators and attachments of the kind '" + group.joint->name() + "'";
    list_batch(name, group.batch, group.batch.stencils());
    Hash64 members;
    append_all(members, group.joints);
    add_part("order of " + name, true, members);
  }
  for (const JointDescription& joint : scene.joints()) {
    if (!joint.can_break()) continue;
    Hash64 limits;
    limits.append(joint.break_force);
    limits.append(joint.break_torque);
    add_part("breaking force of joint '" + joint.name + "'", false, limits);
  }
  for (const AttachmentDescription& attachment : scene.attachments()) {
    Hash64 force;
    force.append(attachment.break_force);
    add_part("breaking force of attachment '" + attachment.name + "'", false, force);
  }
}

void Model::Builder::list_contact() {
  Hash64 friction, pairs, distances, stiffness, cores, restitution;
  bool has_core = false;
  for (int32_t a = 0; a < scene.body_count(); ++a) {
    // Unset: the one of the settings, which are not a part of the model.
    distances.append(scene.contact_distance(BodyId{a}).value_or(-1.0));
    stiffness.append(scene.contact_stiffness(BodyId{a}).value_or(-1.0));
    cores.append(scene.contact_core(BodyId{a}));
    has_core = has_core || scene.contact_core(BodyId{a}) > 0.0;
    friction.append(scene.surface_friction(BodyId{a}));
    pairs.append(scene.motion(BodyId{a}) == Motion::Dynamic);
    pairs.append(scene.contact_possible(BodyId{a}, BodyId{a}));
  }
  for (const auto& [a, b] : scene.pairs_with_friction()) {
    append_pair(friction, a.index, b.index);
    append_friction(friction, scene.friction(a, b));
  }
  for (const auto& [pair, coefficient] : scene.restitutions()) {
    append_pair(restitution, pair.first, pair.second);
    restitution.append(coefficient);
  }
  for (const auto& [a, b] : scene.pairs_without_contact()) append_pair(pairs, a, b);
  for (const JointDescription& joint : scene.joints()) pairs.append(joint.contact);
  for (const AttachmentDescription& attachment : scene.attachments()) {
    pairs.append(attachment.contact);
    if (attachment.sewn) pairs.append(attachment.sewn);
  }
  add_part("coefficients of friction", false, friction);
  if (scene.has_restitution()) add_part("coefficients of restitution", false, restitution);
  add_part("pairs of bodies without contact", false, pairs);
  add_part("contact distances of bodies", false, distances);
  add_part("contact stiffness of bodies", false, stiffness);
  if (has_core) add_part("contact cores of bodies", false, cores);
  if (!scene.surface_motions().empty()) {
    Hash64 moving;  // what moves how fast is in the state
    for (const auto& [body, motion] : scene.surface_motions()) {
      moving.append(body);
      moving.append(motion.center);
    }
    add_part("moving surfaces", true, moving);
  }
  if (!scene.has_anisotropic_friction()) return;
  Hash64 directions;
  for (int32_t a = 0; a < scene.body_count(); ++a) {
    const std::vector<Vec3> of_body = scene.surface_directions(BodyId{a});
    directions.append(of_body.size());
    append_all(directions, of_body);
  }
  add_part("surface directions", false, directions);
}

void Model::Builder::list_parts() {
  list_bodies();
  list_energies();
  list_contact();
}

}  // namespace stark
