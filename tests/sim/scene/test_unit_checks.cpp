#include <stark/sim/scene/unit_checks.h>

#include <doctest/doctest.h>

#include <stark/geometry/shapes.h>

using namespace stark;

namespace {

std::string all(const std::vector<std::string>& texts) {
  std::string joined;
  for (const std::string& text : texts) joined += text + "\n";
  return joined;
}

Scene cube_scene(double size, const SolidMaterial& material) {
  Scene scene;
  scene.add_solid(
      {.name = "cube", .mesh = make_tet_box({size, size, size}, {2, 2, 2}), .material = material});
  return scene;
}

}  // namespace

TEST_CASE("ordinary scenes raise no suspicion of units") {
  for (const auto& preset : materials::solid_presets())
    CHECK(all(check_units(cube_scene(0.1, preset.material), {})) == "");
  for (const auto& preset : materials::shell_presets()) {
    Scene scene;
    scene.add_cloth({.mesh = make_grid(0.5, 0.5, 4, 4), .material = preset.material});
    CHECK(all(check_units(scene, {})) == "");
  }
  for (const auto& preset : materials::rod_presets()) {
    Scene scene;
    scene.add_rod({.mesh = {{{0, 0, 0}, {0.1, 0, 0}, {0.2, 0, 0}}}, .material = preset.material});
    CHECK(all(check_units(scene, {})) == "");
  }
}

TEST_CASE("each mistake of units is named with the object, the value and the unit that is meant") {
  const SolidMaterial rubber = materials::soft_rubber();
  SolidMaterial in_megapascal = rubber, in_grams = rubber, steel_in_gigapascal = materials::steel();
  in_megapascal.youngs_modulus = 0.05;
  in_grams.density = 1.1;
  steel_in_gigapascal.youngs_modulus = 210.0;
  CHECK(all(check_units(cube_scene(100.0, rubber), {})).find("scale it with mesh.scaled") !=
        std::string::npos);
  CHECK(all(check_units(cube_scene(0.1, in_megapascal), {})).find("youngs_modulus = 0.05 Pa") !=
        std::string::npos);
  CHECK(all(check_units(cube_scene(0.1, in_grams), {})).find("density = 1.1 kg/m^3") != std::string::npos);
  CHECK(all(check_units(cube_scene(0.1, steel_in_gigapascal), {})).find("flattens") != std::string::npos);
  SolidMaterial in_percent = rubber;
  in_percent.strain_limit = 10.0;
  CHECK(all(check_units(cube_scene(0.1, in_percent), {})).find("strain_limit = 10 (ordinary") !=
        std::string::npos);
  Settings thick;
  thick.contact.distance = 1e-3;
  CHECK(all(check_units(cube_scene(0.004, rubber), thick)).find("contact_distance below 4e-05 m") !=
        std::string::npos);

  Scene scene;
  ShellMaterial cloth = materials::cotton();
  cloth.density = 150.0;
  cloth.strain_limit = 5.0;
  scene.add_cloth({.name = "towel", .mesh = make_grid(0.5, 0.5, 4, 4), .material = cloth});
  const std::string of_towel = all(check_units(scene, {}));
  CHECK(of_towel.find("cloth 'towel': density = 150 kg/m^2") != std::string::npos);
  CHECK(of_towel.find("cloth 'towel': strain_limit = 5 (ordinary: 1e-06 to 4); it is a ratio: 0.1 is a "
                      "strain of 10 %") != std::string::npos);

  Settings settings;
  settings.gravity = {0, 0, -9810.0};
  settings.time.step = 10.0;
  const std::string text = all(check_units(cube_scene(0.1, materials::steel()), settings));
  CHECK(text.find("gravity of 9810 m/s^2") != std::string::npos);
  CHECK(text.find("time_step = 10 s") != std::string::npos);
}

TEST_CASE(
    "units of sheets: millimetres, grams, megapascal; plates, tents and moduli of surfaces are ordinary") {
  const auto found = [](const ShellMaterial& material, double size = 0.4, int cells = 8) {
    Scene scene;
    scene.add_cloth({.name = "sheet", .mesh = make_grid(size, size, cells, cells), .material = material});
    return all(check_units(scene, {}));
  };
  const auto changed = [](ShellMaterial material, double ShellMaterial::* member, double value) {
    material.*member = value;
    return material;
  };
  const ShellMaterial paper = materials::paper(), cotton = materials::cotton();
  CHECK(found(cotton, 50.0).find("extent of the mesh = 50 m, in cells of 6.25 m") != std::string::npos);
  CHECK(found(changed(paper, &ShellMaterial::density, 80.0)).find("makes 8e+05 kg/m^3") != std::string::npos);
  CHECK(found(changed(cotton, &ShellMaterial::density, 80.0)).find("makes 80000 kg/m^3") !=
        std::string::npos);
  const std::string thick = found(changed(paper, &ShellMaterial::thickness, 0.1));
  CHECK(thick.find("density = 0.08 kg/m^2 at thickness = 0.1 m makes 0.8 kg/m^3") != std::string::npos);
  CHECK(thick.find("1 mm is 1e-3 m") != std::string::npos);
  CHECK(found(changed(cotton, &ShellMaterial::thickness, 0.1)).find("makes 2 kg/m^3") != std::string::npos);
  CHECK(found(changed(paper, &ShellMaterial::youngs_modulus, 3000.0))
            .find("flexural_rigidity is 1e+06 times") != std::string::npos);

  for (const double thickness : {1e-5, 1e-3, 0.02, 0.5})  // foil, sheets, plates, a block
    CHECK(found(materials::plate(2.1e11, 0.3, thickness, 7850.0), 2.0) == "");
  CHECK(found(materials::plate(1e5, 0.3, 0.03, 30.0), 0.5) == "");  // a mat of foam
  CHECK(found(changed(cotton, &ShellMaterial::thickness, 1.0)).find("kg/m^3") != std::string::npos);
  CHECK(found({.density = 1.0, .thickness = 1.0, .youngs_modulus = 2e3}) == "");    // a modulus in N/m
  CHECK(found({.density = 1e-3, .thickness = 1e-6, .youngs_modulus = 2e9}) == "");  // a film
  CHECK(found({.youngs_modulus = 1e5, .flexural_rigidity = 1.0}) == "");  // a core between two skins
  CHECK(found(cotton, 40.0, 100) == "");                                  // a sail
  CHECK(found(cotton, 5.0, 2) == "");                                     // coarse
}

TEST_CASE("friction that is no ratio of forces is named, of bodies and of pairs") {
  Scene scene = cube_scene(0.1, materials::soft_rubber());
  const BodyId cube{0};
  scene.set_friction(cube, cube, 40.0);
  CHECK(all(check_units(scene, {})).find("'cube' and 'cube': friction = 40 (ordinary: 0 to 10)") !=
        std::string::npos);
  scene.set_friction(cube, cube, 2.0);
  CHECK(all(check_units(scene, {})) == "");
  scene.set_default_friction(50.0);
  CHECK(all(check_units(scene, {})).find("scene: default_friction = 50") != std::string::npos);
}

TEST_CASE("rigid bodies in millimetres are named; shells, balloons and weights are ordinary") {
  const auto found = [](double size, double mass, bool hollow = false) {
    Scene scene;
    scene.add_rigid({.name = "part", .mesh = make_box({size, size, size}), .mass = mass, .hollow = hollow});
    return all(check_units(scene, {}));
  };
  CHECK(found(20.0, 0.06) ==
        "rigid body 'part': mass = 0.06 kg in a volume of 8000 m^3 makes 7.5e-06 kg/m^3 (ordinary: 5 to "
        "30000 kg/m^3); if the mesh is not in metres, scale it with mesh.scaled(factor)\n");
  CHECK(found(20.0, 0.06, true) == "");
  CHECK(found(0.3, 0.003) == "");
  CHECK(found(0.005, 0.2) == "");
}

TEST_CASE("fixed and scripted bodies may have any size") {
  Scene scene;
  scene.add_rigid({.mesh = make_box({1000, 1000, 1}), .motion = Motion::Fixed});
  scene.add_rigid({.mesh = make_box({1e-5, 1e-5, 1e-5}), .motion = Motion::Scripted});
  CHECK(all(check_units(scene, {})) == "");
}

TEST_CASE("weak gravity and tiny bodies are named with the tolerances that rule them") {
  const auto texts = [](double size, double gravity, double tolerance = 0.01, double stick = 1e-3) {
    Scene scene;
    scene.add_rigid({.name = "grain", .mesh = make_box({size, size, size}), .mass = 1e-3});
    Settings settings;
    settings.gravity = {0.0, 0.0, -gravity};
    settings.newton.acceleration_tolerance = tolerance;
    settings.contact.stick_velocity = stick;
    return all(check_units(scene, settings));
  };
  CHECK(texts(0.1, 9.81) == "");
  CHECK(texts(0.1, 0.0) == "");
  CHECK(texts(0.1, 1.62) == "");   // the Moon
  CHECK(texts(2e-4, 9.81) == "");  // sand
  CHECK(texts(0.1, 6e-5).find("gravity of 6e-05 m/s^2 is below newton.acceleration_tolerance = 0.01 m/s^2: "
                              "steps may end before it acts; lower that to 6e-08 m/s^2") !=
        std::string::npos);
  CHECK(texts(0.1, 6e-5).find("rigid body 'grain' gains 0.00245 m/s as it falls by its own size") !=
        std::string::npos);
  CHECK(texts(0.1, 6e-5, 6e-8, 2e-6) == "");
}
