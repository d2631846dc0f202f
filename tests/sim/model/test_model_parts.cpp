// Parts of a model: the same scene has the same ones in any process; a change is seen in the part it is in.
#include <doctest/doctest.h>

#include <algorithm>
#include <functional>
#include <string>
#include <vector>

#include <stark/geometry/shapes.h>
#include <stark/mechanics/define.h>
#include <stark/sim/model/model.h>

using namespace stark;

namespace {

/// What a scene of one of each is made of; a test changes one thing.
struct Ingredients {
  ClothDescription cloth{.name = "cloth", .mesh = make_grid(0.2, 0.2, 2, 2), .material = materials::cotton()};
  SolidDescription solid{.name = "cube",
                         .mesh = make_tet_box({0.1, 0.1, 0.1}, {1, 1, 1}),
                         .material = materials::soft_rubber(),
                         .position = {0, 0, 1}};
  RigidDescription rigid{
      .name = "box", .mesh = make_box({0.1, 0.1, 0.1}), .mass = 1.0, .position = {0, 0, 2}};
  double friction = 0.3, stiffness = 2.0, exponent = 2.0;
  std::vector<int32_t> pins{0, 1};
  Settings settings{};
};

std::vector<ModelPart> parts_of(const Ingredients& given) {
  Scene scene;
  const BodyId cloth = scene.add_cloth(given.cloth);
  scene.add_solid(given.solid);
  scene.add_rigid(given.rigid);
  scene.pin(cloth, given.pins);
  scene.set_default_friction(given.friction);
  PotentialDefinition spring = define_potential("spring", 1, "", [&](PotentialBuilder& b) {
    const auto d = symbolic::squared_norm(b.x(0));
    return b.parameter("stiffness", "N/m", "") * (given.exponent == 2.0 ? d : d * d);
  });
  spring.translation_invariant = spring.rotation_invariant = false;
  scene.add_energy({.name = "anchor",
                    .potential = spring,
                    .points = {vertex_points(cloth, {8})},
                    .values = {{"stiffness", {{given.stiffness}}}}});
  Energies energies;
  return Model(scene, given.settings, energies).parts();
}

/// Names of the parts that differ from those of the plain scene.
std::vector<std::string> changed(const std::function<void(Ingredients&)>& change) {
  Ingredients other;
  change(other);
  const std::vector<ModelPart> a = parts_of({}), b = parts_of(other);
  std::vector<std::string> names;
  REQUIRE(a.size() == b.size());
  for (size_t k = 0; k < a.size(); ++k) {
    CHECK(a[k].name == b[k].name);
    if (a[k].hash != b[k].hash) names.push_back(a[k].name);
  }
  return names;
}

bool contains(const std::vector<std::string>& names, const std::string& name) {
  return std::find(names.begin(), names.end(), name) != names.end();
}

using PartNames = std::vector<std::string>;

}  // namespace

TEST_CASE("equal scenes have equal parts, whatever the threads, the back end and the start") {
  CHECK(changed([](Ingredients&) {}).empty());
  CHECK(
      changed([](Ingredients& i) { i.settings.execution.backend = symbolic::Backend::Interpreter; }).empty());
  CHECK(changed([](Ingredients& i) { i.settings.execution.threads = 3; }).empty());
  CHECK(changed([](Ingredients& i) { i.cloth.velocity = {1, 2, 3}; }).empty());
  CHECK(changed([](Ingredients& i) { i.cloth.color = Color{1, 0, 0}; }).empty());
}

TEST_CASE("names of parts are all different") {
  std::vector<std::string> names;
  for (const ModelPart& part : parts_of({})) names.push_back(part.name);
  std::sort(names.begin(), names.end());
  CHECK(std::adjacent_find(names.begin(), names.end()) == names.end());
}

TEST_CASE("a change is seen in its part") {
  CHECK(changed([](Ingredients& i) { i.friction = 0.31; }) == PartNames{"coefficients of friction"});
  CHECK(changed([](Ingredients& i) { i.rigid.contact_distance = 1e-3; }) ==
        PartNames{"contact distances of bodies"});
  CHECK(changed([](Ingredients& i) { i.stiffness = 2.1; }) == PartNames{"values of the energy 'anchor'"});
  CHECK(changed([](Ingredients& i) { i.exponent = 4.0; }) == PartNames{"formula of the energy 'anchor'"});
  CHECK(contains(changed([](Ingredients& i) { i.pins = {0, 2}; }),
                 "kind, motion, topology or pins of cloth 'cloth'"));
  CHECK(contains(changed([](Ingredients& i) { i.solid.mesh.vertices[0].x += 1e-12; }),
                 "rest shape of solid 'cube'"));
  CHECK(contains(changed([](Ingredients& i) { i.rigid.mass = 1.1; }), "mass of rigid 'box'"));
  CHECK(contains(
      changed([](Ingredients& i) { std::swap(i.cloth.mesh.triangles[0], i.cloth.mesh.triangles[1]); }),
      "kind, motion, topology or pins of cloth 'cloth'"));
  const PartNames stiffer = changed([](Ingredients& i) { i.solid.material.youngs_modulus *= 2.0; });
  REQUIRE_FALSE(stiffer.empty());
  for (const std::string& name : stiffer) CHECK(name.find("of 'cube'") != std::string::npos);
}

TEST_CASE("parts of quadratic solids are places in the model, the same each time") {
  // Many elements: the rows of their deformation gradients outnumber the sites.
  Ingredients quadratic;
  quadratic.solid.mesh = to_quadratic(make_tet_box({0.1, 0.1, 0.1}, {4, 4, 4}));
  const std::vector<ModelPart> first = parts_of(quadratic), second = parts_of(quadratic);
  REQUIRE(first.size() == second.size());
  for (size_t k = 0; k < first.size(); ++k) {
    CAPTURE(first[k].name);
    CHECK(first[k].hash == second[k].hash);
  }
}

TEST_CASE("surface directions are a part where friction depends on them") {
  const auto parts = [](const Vec3& direction, double across, bool isotropic) {
    Scene scene;
    const BodyId a = scene.add_rigid({.name = "a", .mesh = make_box({1, 1, 1}), .motion = Motion::Fixed});
    const BodyId b =
        scene.add_rigid({.name = "b", .mesh = make_box({1, 1, 1}), .mass = 1.0, .position = {0.0, 0.0, 2.0}});
    scene.set_surface_directions(a, {direction});
    scene.set_anisotropic_friction(a, b, {isotropic ? across : 0.1, across});
    Energies energies;
    return Model(scene, {}, energies).parts();
  };
  const auto differing = [&](const std::vector<ModelPart>& x, const std::vector<ModelPart>& y) {
    PartNames names;
    REQUIRE(x.size() == y.size());
    for (size_t k = 0; k < x.size(); ++k)
      if (x[k].hash != y[k].hash) names.push_back(x[k].name);
    return names;
  };
  const std::vector<ModelPart> plain = parts({1, 0, 0}, 0.4, false);
  CHECK(differing(plain, parts({1, 0, 0}, 0.4, false)).empty());
  CHECK(differing(plain, parts({0, 1, 0}, 0.4, false)) == PartNames{"surface directions"});
  CHECK(differing(plain, parts({1, 0, 0}, 0.5, false)) == PartNames{"coefficients of friction"});
  // Without such a pair directions do not matter.
  CHECK(differing(parts({1, 0, 0}, 0.4, true), parts({0, 1, 0}, 0.4, true)).empty());
}

TEST_CASE("rigid bodies of many vertices move as one piece on their surfaces, others do not") {
  Scene scene;
  const BodyId ball = scene.add_rigid({.name = "ball", .mesh = make_icosphere(0.1, 3), .mass = 1.0});
  const BodyId box = scene.add_rigid({.name = "box", .mesh = make_box({1, 1, 1}), .mass = 1.0});
  const BodyId cloth = scene.add_cloth(
      {.name = "cloth", .mesh = make_grid(0.2, 0.2, 20, 20), .material = materials::cotton()});
  const Settings settings;
  Energies energies;
  const Model model(scene, settings, energies);
  const SurfaceMesh mesh = model.make_surfaces(scene, settings).mesh;
  CHECK(mesh.frame_of(box.index) == nullptr);  // eight vertices
  CHECK(mesh.frame_of(cloth.index) == nullptr);
  const GroupFrame* frame = mesh.frame_of(ball.index);
  REQUIRE(frame != nullptr);
  for (const int32_t site : frame->sites) CHECK(mesh.vertex_group[site] == ball.index);
}
