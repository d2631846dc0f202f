// Rigid bodies of a model: mass in the principal frame, sites; inertia of everything that moves.
#include <algorithm>

#include <stark/geometry/face_levers.h>
#include <stark/geometry/mass_properties.h>
#include <stark/sim/model/model_builder.h>

namespace stark {

void Model::Builder::add_rigids() {
  for (int32_t i = 0; i < scene.body_count(); ++i) {
    const BodyId id{i};
    if (scene.kind(id) != BodyKind::Rigid) continue;
    const RigidDescription& rigid = scene.rigid(id);
    ModelBody& body = model.bodies_[i];
    body.rigid_index = static_cast<int32_t>(model.rigid_masses_.size());
    body.triangles = rigid.mesh.triangles;
    body.site_count = static_cast<int32_t>(rigid.mesh.vertices.size());
    RigidMass mass;
    if (rigid.motion == Motion::Dynamic) {
      const RigidInertia& inertia = scene.rigid_inertia(id);
      const PrincipalAxes principal = compute_principal_axes(inertia.tensor);
      mass.mass = inertia.mass;
      mass.moments = principal.values;
      for (int k = 0; k < 3; ++k)
        mass.second_moments[k] =
            std::max(0.0, 0.5 * (mass.moments.x + mass.moments.y + mass.moments.z) - mass.moments[k]);
      mass.linear_damping = rigid.linear_damping;
      mass.angular_damping = rigid.angular_damping;
      mass.resistance = std::min({mass.moments.x, mass.moments.y, mass.moments.z});
      body.centre = inertia.center_of_mass;
      body.axes = principal.axes;
    }
    for (const Vec3& v : rigid.mesh.vertices) mass.reach = std::max(mass.reach, norm(v - body.centre));
    model.rigid_masses_.push_back(mass);
    rigid_bodies.push_back(i);
    body_prescribed.push_back(rigid.motion != Motion::Dynamic);
    rotation_prescribed.push_back(rigid.motion != Motion::Dynamic);
  }
}

void Model::Builder::add_axis_sites(int32_t body) {
  axis_sites[body] = static_cast<int32_t>(sites.size());
  for (int k = 0; k < 3; ++k)
    sites.push_back({.kind = SiteKind::RigidDirection,
                     .index = body,
                     .local = Mat3::identity().column(k),
                     .points = {},
                     .weights = {}});
}

int32_t Model::Builder::add_rigid_site(const ModelBody& body, const Vec3& place) {
  const Vec3 local = transpose(body.axes) * (place - body.centre);
  return add_site(
      {.kind = SiteKind::RigidPoint, .index = body.rigid_index, .local = local, .points = {}, .weights = {}},
      place);
}

void Model::Builder::add_rigid_sites() {
  centre_sites.assign(body_prescribed.size(), -1);
  axis_sites.assign(body_prescribed.size(), -1);
  for (const int32_t i : rigid_bodies) {
    ModelBody& body = model.bodies_[i];
    body.first_site = static_cast<int32_t>(sites.size());
    for (const Vec3& v : scene.rigid(BodyId{i}).mesh.vertices) add_rigid_site(body, v);
  }
  for (const int32_t i : rigid_bodies) {
    const ModelBody& body = model.bodies_[i];
    if (body_prescribed[body.rigid_index]) continue;
    centre_sites[body.rigid_index] = static_cast<int32_t>(sites.size());
    sites.push_back(
        {.kind = SiteKind::RigidPoint, .index = body.rigid_index, .local = {}, .points = {}, .weights = {}});
    add_axis_sites(body.rigid_index);
    model.rest_positions_.resize(sites.size());
  }
}

void Model::Builder::add_levers() {
  if (!settings.contact.enabled || !settings.contact.friction) return;
  for (const int32_t i : rigid_bodies) {
    // Directions may differ from triangle to triangle, so such a face is not taken for one (make_surfaces).
    if (scene.surface_directions(BodyId{i}).size() > 1) continue;
    const ModelBody& body = model.bodies_[i];
    for (const FaceLever& lever : find_face_levers(scene.rigid(BodyId{i}).mesh.vertices, body.triangles)) {
      const int32_t site = add_rigid_site(body, lever.place);
      model.levers_.push_back({site, i, lever.vertex, lever.triangle});
    }
  }
}

void Model::Builder::add_energies(BodyId, const RigidDescription&) {}  // nothing of it strains

void Model::Builder::add_inertia() {
  // Translation of points and centres of mass, with gravity; rotation of bodies through their axis
  // directions.
  std::vector<int32_t> translations, rotations, translation_subjects, rotation_subjects;
  for (size_t p = 0; p < point_prescribed.size(); ++p)
    if (!point_prescribed[p]) {
      translations.push_back(static_cast<int32_t>(p));
      translation_subjects.push_back(static_cast<int32_t>(p));
    }
  for (size_t b = 0; b < body_prescribed.size(); ++b) {
    if (!body_prescribed[b]) {
      translations.push_back(centre_sites[b]);
      translation_subjects.push_back(-1 - static_cast<int32_t>(b));
    }
    for (int k = 0; k < 3 && !rotation_prescribed[b]; ++k) {
      rotations.push_back(axis_sites[b] + k);
      rotation_subjects.push_back(static_cast<int32_t>(3 * b) + k);
    }
  }
  PotentialBatch& moving =
      add_batch(compose("inertia", {models::point_inertia(), models::gravity()}), translations, "");
  for (int64_t e = 0; e < moving.size(); ++e) {
    const int32_t subject = translation_subjects[e];
    moving.set("mass", e,
               subject >= 0 ? model.point_masses_[subject] : model.rigid_masses_[-1 - subject].mass);
    moving.set(
        "damping", e,
        subject >= 0 ? model.point_damping_[subject] : model.rigid_masses_[-1 - subject].linear_damping);
  }
  moving.set_uniform("gravity", {&settings.gravity.x, 3});
  energies.batches.back().role = ModelBatch::Role::Inertia;
  energies.batches.back().subject = translation_subjects;
  PotentialBatch& turning = add_batch(models::point_inertia(), rotations, "");
  for (int64_t e = 0; e < turning.size(); ++e) {
    const RigidMass& mass = model.rigid_masses_[rotation_subjects[e] / 3];
    turning.set("mass", e, mass.second_moments[rotation_subjects[e] % 3]);
    turning.set("damping", e, mass.angular_damping);
  }
  energies.batches.back().role = ModelBatch::Role::RotationalInertia;
  energies.batches.back().subject = rotation_subjects;
}

}  // namespace stark
