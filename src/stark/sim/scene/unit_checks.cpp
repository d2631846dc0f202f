#include <stark/sim/scene/unit_checks.h>

#include <algorithm>
#include <cmath>

#include <stark/geometry/mass_properties.h>
#include <stark/geometry/topology.h>
#include <stark/sim/scene/body_checks.h>

namespace stark {

namespace {

struct Range {
  double low, high;
  bool contains(double value) const { return low <= value && value <= high; }
};

/// From light foams to osmium [kg/m^3]; from films of 0.1 um to plates of a metre [kg/m^2]; from weak gels to
/// diamond [Pa].
constexpr Range kVolumeDensity{5.0, 30e3}, kAreaDensity{1e-4, 1e4}, kModulus{10.0, 2e12};
/// Green strains at which materials stiffen, up to three times their length.
constexpr Range kStrainLimit{1e-6, 4.0};
/// Mass of a sheet over its area and thickness: none is lighter than air [kg/m^3]. Sheets of a tenth of their
/// extent are light foams, but those of 1 m, whose modulus is meant to be one of the surface [N/m].
constexpr Range kSheetDensity{1.0, 30e3};
constexpr double kThickSheet = 0.1, kNoThickness = 1.0;
/// What is a million, a milliard or a milliardth of the rigidity of a homogeneous sheet, within this factor,
/// is one of a modulus in MPa or GPa, or of a thickness in mm.
constexpr double kLikely = 2.0;
/// Mass of a rigid body over the volume that its surface encloses: less than that of any balloon [kg/m^3].
/// There is no upper bound, since weights may have small shapes.
constexpr double kLightestRigid = 0.01;
/// Extent of what is simulated as moving [m]. Cloth that is larger than a room has cells below half a metre.
constexpr Range kExtent{1e-4, 50.0};
constexpr double kLargeCloth = 10.0, kLargeCell = 0.5;
/// Coulomb's coefficient, from none to soft rubber and gecko-like pads.
constexpr Range kFriction{0.0, 10.0};
constexpr double kThickestContact = 0.2;  ///< contact distance over the extent of a body
constexpr double kHeaviest = 10.0;        ///< pressure of a body's own weight over its Young's modulus
constexpr double kStrongestGravity = 300.0, kLongestStep = 1.0;  ///< [m/s^2], the Sun's; [s]
/// Speed below which friction sticks, over that of what falls by its own size: above, all is friction at
/// rest.
constexpr double kFastestStick = 0.1;
constexpr double kFine = 1e-3;  ///< of gravity and of speeds, for tolerances that hardly show

class Suspicions {
 public:
  void check(const std::string& owner, const char* name, double value, const char* unit, const Range& range,
             const char* hint) {
    if (range.contains(value)) return;
    add(owner + ": " + name + " = " + quantity_text(value, unit) + " (ordinary: " + to_text(range.low) +
        " to " + quantity_text(range.high, unit) + "); " + hint);
  }
  void add(std::string text) { list_.push_back(std::move(text)); }
  std::vector<std::string> take() { return std::move(list_); }

 private:
  std::vector<std::string> list_;
};

void check_sheet(const std::string& owner, const MaterialScale& material, const Vec3& size, Suspicions& out) {
  const double t = material.thickness, density = material.density / t;
  const bool is_thick = t > kThickSheet * max_abs(size) && t != kNoThickness;
  if (!kAreaDensity.contains(material.density))
    out.check(owner, "density", material.density, "kg/m^2", kAreaDensity,
              "of cloth it is the mass of a unit of area: 1 g/m^2 is 1e-3 kg/m^2");
  else if (!kSheetDensity.contains(density) || (is_thick && density < kVolumeDensity.low))
    out.add(owner + ": density = " + quantity_text(material.density, "kg/m^2") +
            " at thickness = " + quantity_text(t, "m") + " makes " + rough_text(density, "kg/m^3") +
            " (ordinary: " + to_text(kVolumeDensity.low) + " to " +
            quantity_text(kVolumeDensity.high, "kg/m^3") +
            "); of cloth the density is the mass of a unit of area: 1 g/m^2 is 1e-3 kg/m^2; 1 mm is 1e-3 m");
  const auto is_about = [&](double factor) {
    return factor / kLikely < material.rigidity_ratio && material.rigidity_ratio < factor * kLikely;
  };
  if (is_about(1e6) || is_about(1e9) || is_about(1e-9))
    out.add(owner + ": flexural_rigidity is " + rough_text(material.rigidity_ratio, "1") +
            " times that of a sheet of its youngs_modulus and thickness; " +
            (is_about(1e-9) ? "1 mm is 1e-3 m" : "1 MPa is 1e6 Pa, 1 GPa is 1e9 Pa"));
}

/// Root of the mean area of the triangles of a cloth, twice [m].
double cell_size(const Scene& scene, BodyId body) {
  const TriangleMesh& mesh = scene.cloth(body).mesh;
  double area = 0.0;
  for (const Index3& t : mesh.triangles)
    area += norm(cross(mesh.vertices[t[1]] - mesh.vertices[t[0]], mesh.vertices[t[2]] - mesh.vertices[t[0]]));
  return std::sqrt(area / static_cast<double>(mesh.triangles.size()));
}

void check_extent(const Scene& scene, BodyId body, const std::string& owner, double extent, Suspicions& out) {
  const char* const hint = "if the mesh is not in metres, scale it with mesh.scaled(factor)";
  out.check(owner, "extent of the mesh", extent, "m", kExtent, hint);
  if (scene.kind(body) != BodyKind::Cloth || !kExtent.contains(extent) || extent <= kLargeCloth) return;
  if (const double cell = cell_size(scene, body); cell > kLargeCell)
    out.add(owner + ": extent of the mesh = " + quantity_text(extent, "m") + ", in cells of " +
            rough_text(cell, "m") + " (ordinary: below " + quantity_text(kLargeCell, "m") + "); " + hint);
}

void check_material(const Scene& scene, BodyId body, const Vec3& size, const Vec3& gravity, Suspicions& out) {
  const BodyKindRow& row = row_of(scene.kind(body));
  if (!row.material_scale) return;
  const std::string owner = owner_text(scene.kind(body), scene.name(body));
  const MaterialScale material = row.material_scale(scene, body);
  const double modulus = material.youngs_modulus;
  if (material.is_area_density)
    check_sheet(owner, material, size, out);
  else
    out.check(owner, "density", material.density, "kg/m^3", kVolumeDensity, "1 g/cm^3 is 1000 kg/m^3");
  if (std::isfinite(material.strain_limit))
    out.check(owner, "strain_limit", material.strain_limit, "", kStrainLimit,
              "it is a ratio: 0.1 is a strain of 10 %");
  if (!std::isfinite(modulus)) return;
  out.check(owner, "youngs_modulus", modulus, "Pa", kModulus, "1 MPa is 1e6 Pa, 1 GPa is 1e9 Pa");
  const double weight = material.density * std::fabs(dot(gravity, size));
  if (row.can_be_filled && weight > kHeaviest * modulus)
    out.add(owner + ": its weight presses with " + rough_text(weight, "Pa") + ", " +
            to_text(std::round(weight / modulus)) + " times its youngs_modulus of " +
            quantity_text(modulus, "Pa") + ", and flattens it; 1 MPa is 1e6 Pa, 1 GPa is 1e9 Pa");
}

void check_rigid(const Scene& scene, BodyId body, Suspicions& out) {
  if (scene.kind(body) != BodyKind::Rigid || !scene.is_filled(body)) return;
  const TriangleMesh& mesh = scene.rigid(body).mesh;
  if (!is_closed(mesh.triangles)) return;
  const double volume = compute_solid_mass_properties(mesh.vertices, mesh.triangles, 1.0).measure;
  const double mass = scene.rigid_inertia(body).mass;
  if (mass >= kLightestRigid * volume) return;
  out.add(owner_text(BodyKind::Rigid, scene.name(body)) + ": mass = " + quantity_text(mass, "kg") +
          " in a volume of " + rough_text(volume, "m^3") + " makes " + rough_text(mass / volume, "kg/m^3") +
          " (ordinary: " + to_text(kVolumeDensity.low) + " to " +
          quantity_text(kVolumeDensity.high, "kg/m^3") +
          "); if the mesh is not in metres, scale it with mesh.scaled(factor)");
}

/// 0 of automatic ones: they follow from the size of the body and are never too large [m].
double given_contact_distance(const Scene& scene, BodyId body, const Settings& settings) {
  return scene.contact_distance(body).value_or(settings.contact.distance);
}

void check_friction(const Scene& scene, Suspicions& out) {
  const char* const hint = "Coulomb's coefficient is the ratio of two forces, not an angle or a percentage";
  out.check("scene", "default_friction", scene.default_friction(), "1", kFriction, hint);
  for (int32_t i = 0; i < scene.body_count(); ++i)
    if (const auto own = scene.body_friction({i}))
      out.check(owner_text(scene.kind({i}), scene.name({i})), "friction", *own, "1", kFriction, hint);
  for (const auto& [a, b] : scene.pairs_with_friction())
    out.check("'" + scene.name(a) + "' and '" + scene.name(b) + "'", "friction",
              scene.friction(a, b).sticking, "1", kFriction, hint);
}

/// Where gravity is weak, or bodies are tiny, tolerances that are meant for neither rule the motion.
void check_slowness(const Scene& scene, const Settings& settings, Suspicions& out) {
  const double g = norm(settings.gravity), tolerance = settings.newton.acceleration_tolerance;
  if (g == 0.0 || !has_inertia(settings.time.integrator)) return;
  if (g < tolerance)
    out.add("the settings: gravity of " + quantity_text(g, "m/s^2") +
            " is below newton.acceleration_tolerance = " + quantity_text(tolerance, "m/s^2") +
            ": steps may end before it acts; lower that to " +
            quantity_text(rough_below(kFine * g), "m/s^2"));
  if (!settings.contact.enabled || !settings.contact.friction) return;
  int32_t smallest = -1;
  double extent = 0.0;
  for (int32_t i = 0; i < scene.body_count(); ++i) {
    if (scene.motion({i}) != Motion::Dynamic) continue;
    const double own = max_abs(box_size(scene.initial_positions({i})));
    if (smallest < 0 || own < extent) smallest = i, extent = own;
  }
  const double speed = std::sqrt(g * extent), stick = settings.contact.stick_velocity;
  if (smallest < 0 || stick <= kFastestStick * speed) return;
  out.add(owner_text(scene.kind({smallest}), scene.name({smallest})) + " gains " + rough_text(speed, "m/s") +
          " as it falls by its own size, and contact.stick_velocity is " + quantity_text(stick, "m/s") +
          ": friction gives way by more than it should; lower that to " +
          quantity_text(rough_below(kFine * speed), "m/s"));
}

}  // namespace

std::vector<std::string> check_units(const Scene& scene, const Settings& settings) {
  Suspicions suspicions;
  if (norm(settings.gravity) > kStrongestGravity)
    suspicions.add("the settings: gravity of " + quantity_text(norm(settings.gravity), "m/s^2") +
                   " (ordinary: 9.81 m/s^2); in mm/s^2 it would be 9810");
  if (settings.time.step > kLongestStep && has_inertia(settings.time.integrator))
    suspicions.add("the settings: time_step = " + quantity_text(settings.time.step, "s") +
                   " (ordinary: 0.001 to 0.05 s); write " + to_text(settings.time.step / 1000.0) + " if " +
                   quantity_text(settings.time.step, "ms") + " are meant");
  for (int32_t i = 0; i < scene.body_count(); ++i) {
    const BodyId body{i};
    if (scene.motion(body) != Motion::Dynamic) continue;
    const std::string owner = owner_text(scene.kind(body), scene.name(body));
    const Vec3 size = box_size(scene.initial_positions(body));
    check_extent(scene, body, owner, max_abs(size), suspicions);
    if (const double distance = given_contact_distance(scene, body, settings);
        settings.contact.enabled && distance > kThickestContact * max_abs(size))
      suspicions.add(owner + ": contact distance of " + quantity_text(distance, "m") +
                     " for an extent of the mesh of " + rough_text(max_abs(size), "m") +
                     "; if the mesh is in metres, give it a contact_distance below " +
                     quantity_text(rough_below(0.01 * max_abs(size)), "m"));
    check_material(scene, body, size, settings.gravity, suspicions);
    check_rigid(scene, body, suspicions);
  }
  if (settings.contact.enabled) check_friction(scene, suspicions);
  check_slowness(scene, settings, suspicions);
  return suspicions.take();
}

}  // namespace stark
