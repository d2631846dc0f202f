// Laws and fields of bodies: where values come from, what is refused, and what reaches the model.
#include <doctest/doctest.h>

#include <string>

#include <stark/base/error.h>
#include <stark/geometry/shapes.h>
#include <stark/geometry/topology.h>
#include <stark/sim/model/model.h>
#include <stark/sim/scene/material_fields.h>
#include <stark/sim/scene/registry.h>
#include <stark/sim/simulation.h>

using namespace stark;

namespace {

SolidDescription box() { return {.name = "cube", .mesh = make_tet_box({1, 1, 1}, {1, 1, 1})}; }
ClothDescription sheet() { return {.name = "sheet", .mesh = make_grid(1.0, 1.0, 2, 2)}; }

template <typename Description>
std::string message_of(const Description& body) {
  try {
    check_fields("body 'b'", body);
  } catch (const InvalidArgument& error) {
    return error.what();
  }
  return "accepted";
}

bool contains(const std::string& text, const char* part) { return text.find(part) != std::string::npos; }

FieldValues ramp(size_t count, double low, double high) {
  FieldValues values{.values = {}, .per_element = true};
  for (size_t k = 0; k < count; ++k) values.values.push_back(low + (high - low) * double(k) / double(count));
  return values;
}

double total(const std::vector<double>& numbers) {
  double sum = 0.0;
  for (const double n : numbers) sum += n;
  return sum;
}

}  // namespace

TEST_CASE("values come from the fields of a body, else from its material") {
  SolidDescription solid = box();
  CHECK(elastic_energy(solid).values.at("youngs_modulus").values == std::vector<double>{1e4});
  CHECK_FALSE(elastic_energy(solid).values.contains("strain_damping"));
  solid.fields["youngs_modulus"] = ramp(12, 1e4, 2e4);
  CHECK(elastic_energy(solid).values.at("youngs_modulus").per_element);
  solid.law = models::mooney_rivlin();
  solid.fields = {{"c10", {{1e3}, false}}, {"c01", {{0.0}, false}}, {"bulk_modulus", {{1e5}, false}}};
  CHECK(message_of(solid) == "accepted");
  CHECK(elastic_energy(solid).values.at("c10").values == std::vector<double>{1e3});
}

TEST_CASE("missing, superfluous and wrong values are refused by name") {
  SolidDescription solid = box();
  solid.law = models::mooney_rivlin();
  solid.fields = {{"c10", {{1e3}, false}}, {"c01", {{0.0}, false}}};
  CHECK(contains(message_of(solid), "'mooney_rivlin' needs a value of bulk_modulus [Pa]"));
  solid.fields["bulk_modulus"] = {{-2.0}, false};
  CHECK(contains(message_of(solid), "bulk_modulus = -2 Pa: must be > 0"));
  solid = box();
  solid.fields["youngs_modulos"] = {{1e4}, false};
  CHECK(contains(message_of(solid), "did you mean 'youngs_modulus'?"));
  solid.fields = {{"density", {{1e3, 1e3}, true}}};
  CHECK(contains(message_of(solid), "density has 2 numbers: must be 1 for each of the 12 elements"));
}

TEST_CASE("cloth of a law with directions has warp along x, along y on triangles across x, or as given") {
  ClothDescription cloth = sheet();
  cloth.law = models::orthotropic_cloth();
  for (const char* name : {"warp_modulus", "weft_modulus", "shear_modulus"})
    cloth.fields[name] = {{1e3}, false};
  CHECK(message_of(cloth) == "accepted");
  CHECK(elastic_energy(cloth).values.at("warp_direction").values[0] == 1.0);
  for (Vec3& v : cloth.mesh.vertices) v = {v.z, v.x, v.y};  // now in the plane of y and z
  CHECK(elastic_energy(cloth).values.at("warp_direction").values[1] == 1.0);
  CHECK(message_of(cloth) == "accepted");
  cloth.fields["warp_direction"] = {{1, 0, 0}, false};
  CHECK(contains(message_of(cloth), "is normal to triangle 0"));
}

namespace {

double mass_of_model(const Scene& scene) {
  Energies energies;
  return total(Model(scene, Settings{}, energies).point_masses());
}

}  // namespace

TEST_CASE("densities of elements become masses of vertices") {
  Scene scene;
  SolidDescription solid = box();
  solid.fields["density"] = ramp(12, 100.0, 200.0);
  const std::vector<double> volumes = compute_element_volumes(solid.mesh);
  double mass = 0.0;
  for (size_t e = 0; e < volumes.size(); ++e) mass += volumes[e] * solid.fields["density"].values[e];
  scene.add_solid(solid);
  CHECK(mass_of_model(scene) == doctest::Approx(mass).epsilon(1e-12));
  Scene flat;
  ClothDescription cloth = sheet();
  cloth.fields["density"] = {{0.7}, false};
  flat.add_cloth(cloth);
  CHECK(mass_of_model(flat) == doctest::Approx(0.7).epsilon(1e-12));
}

TEST_CASE("a field of equal values gives the same motion as the value of the material") {
  const auto simulate = [](bool fields) {
    Scene scene;
    SolidDescription solid = box();
    solid.material.youngs_modulus = 3e3;
    solid.material.strain_damping = 2.0;
    if (fields) {
      solid.fields["youngs_modulus"] = {std::vector<double>(12, 3e3), true};
      solid.fields["strain_damping"] = {std::vector<double>(12, 2.0), true};
    }
    scene.pin(scene.add_solid(solid), std::vector<int32_t>{0, 1});
    Simulation simulation(scene, Settings{});
    for (int k = 0; k < 3; ++k) simulation.step();
    return simulation.state().point_position;
  };
  const std::vector<Vec3> plain = simulate(false), fields = simulate(true);
  for (size_t i = 0; i < plain.size(); ++i) CHECK(plain[i] == fields[i]);
}

TEST_CASE("bending of cloth may differ from triangle to triangle") {
  ClothDescription cloth = sheet();
  cloth.fields = {{"bending_stiffness", ramp(8, 1.0, 3.0)}};
  CHECK(message_of(cloth) == "accepted");
  CHECK(bending_stiffness(cloth, 4) == 2.0);
  CHECK(flexural_rigidity(cloth, 4) == cloth.material.flexural_rigidity);
  keep_largest_bending(cloth.material, cloth.fields);
  CHECK(cloth.material.bending_stiffness == 2.75);
  cloth.fields["flexural_rigidity"] = {{-1.0}, false};
  CHECK(contains(message_of(cloth), "flexural_rigidity = -1 N m: must be >= 0"));
  SolidDescription solid = box();
  solid.fields = {{"bending_stiffness", {{1.0}, false}}};
  CHECK(contains(message_of(solid), "has no such parameter by element; give one value for the whole body"));
}
