// Constraints as a system of their own, against the same constraints among others.
#include <doctest/doctest.h>

#include <random>

#include <stark/base/rotation.h>
#include <stark/mechanics/define.h>
#include <stark/mechanics/loop_system.h>
#include <stark/mechanics/site_gradient.h>
#include <support/mixed_scene.h>

using namespace stark;
using namespace stark::test;

namespace {

/// Keeps two points as far from each other as they were at the start of the step, but for "longer".
JointDefinition rod() {
  return define_joint("rod", "", [](JointBuilder& j) {
    const auto before = symbolic::norm(j.a_prev.origin - j.b_prev.origin);
    j.hold(symbolic::norm(j.a.origin - j.b.origin) - before - j.parameter("longer", "m", "by this"),
           ResidualUnit::Length);
  });
}

/// Points 0 to 3 are free, 4 follows them, 5 is prescribed; bodies 0 and 1 are free, 2 is prescribed.
struct Scene {
  static constexpr int kFollower = 4;

  Scene() {
    RandomPoints random(3);
    for (int p = 0; p < 6; ++p) configuration.point_position.push_back(random.point());
    std::vector<Site> sites;
    for (int p = 0; p < 6; ++p) sites.push_back({.kind = SiteKind::Point, .index = p});
    EmbeddedPoints embedded;
    const int32_t support = embedded.add_support(std::array{0, 1, 2, 3});
    const auto embed = [&](std::array<double, 4> weights) {
      return Site{.kind = SiteKind::Embedded, .index = embedded.add_row(support, weights)};
    };
    sites[kFollower] = embed({0.4, 0.3, 0.2, 0.1});
    for (int b = 0; b < 3; ++b) {
      configuration.body_position.push_back(random.point());
      configuration.body_rotation.push_back(exp_rotation(random.point()));
      for (int k = 0; k < 2; ++k)
        sites.push_back({.kind = SiteKind::RigidPoint, .index = b, .local = random.point()});
    }
    sites.push_back({.kind = SiteKind::Barycentric, .points = {3, 0, 2, 1}, .weights = {0.1, 0.2, 0.3, 0.4}});
    sites.push_back(embed({0.1, 0.2, 0.3, 0.4}));
    map = KinematicMap(DofLayout::build({false, false, false, false, true, true}, {false, false, true}),
                       sites, embedded);
    map.follow(configuration.point_position);
  }

  std::vector<Vec3> positions(const Configuration& at) const {
    std::vector<Vec3> x(map.site_count());
    map.positions(at, x);
    return x;
  }

  KinematicMap map;
  Configuration configuration;
};

/// Two groups of rods between such sites, with numbers of their own.
ConstraintSet make_constraints(const std::vector<std::vector<std::pair<int32_t, int32_t>>>& rods,
                               std::span<const Vec3> x) {
  std::vector<ConstraintGroup> groups;
  int32_t joints = 0;
  for (const auto& pairs : rods) {
    const auto joint =
        std::make_shared<const Joint>(rod(), FrameKind::Axes, FrameKind::Axes, symbolic::Backend::Automatic);
    ConstraintGroup group{joint, PotentialBatch(joint->potential()), {}};
    std::vector<int32_t> stencils;
    for (const auto& [a, b] : pairs) {
      stencils.insert(stencils.end(), {a, b});
      group.joints.push_back(joints++);
    }
    group.batch.resize(stencils);
    group.batch.set_previous(x);
    group.batch.set_initial(x);
    for (int64_t e = 0; e < group.batch.size(); ++e)
      group.batch.set("longer", e, 0.01 * static_cast<double>(e + 1));
    groups.push_back(std::move(group));
  }
  ConstraintSet constraints(std::move(groups));
  ConstraintSet::Inputs inputs;
  for (int64_t r = 0; r < constraints.residual_count(); ++r) {
    inputs.multipliers.push_back(1.0 + static_cast<double>(r));
    inputs.penalties.push_back(100.0 - static_cast<double>(r));
  }
  constraints.set_inputs(inputs);
  return constraints;
}

/// Of the energies of these constraints, by unknown.
std::vector<double> gradient_of(const KinematicMap& map, ConstraintSet& constraints, const Configuration& at,
                                std::span<const Vec3> x) {
  ThreadPool pool(1);
  Assembler assembler(map, pool);
  std::vector<PotentialBatch*> batches;
  for (ConstraintGroup& group : constraints.groups()) batches.push_back(&group.batch);
  assembler.set_static_batches(batches);
  std::vector<double> gradient(3 * static_cast<size_t>(map.layout().block_count));
  assembler.assemble_gradient(at, x, gradient);
  return gradient;
}

/// Sites: 0 to 5 points, 6 to 11 those of bodies, 12 barycentric, 13 embedded.
const std::vector<std::vector<std::pair<int32_t, int32_t>>> kRods = {
    {{6, 9}, {1, 11}, {Scene::kFollower, 7}, {5, 8}}, {{0, 10}, {12, 6}, {9, 13}}};

}  // namespace

TEST_CASE("a system of some constraints has their residuals and forces wherever its unknowns are") {
  const Scene scene;
  const std::vector<Vec3> x = scene.positions(scene.configuration);
  const struct {
    std::vector<bool> chosen;     // by constraint
    std::vector<int32_t> blocks;  // of the unknowns of the system: points 0 to 3, bodies 4, 5 and 6, 7
  } cases[] = {
      {{true, false, false, false, false, false, false}, {4, 5, 6, 7}},
      {{false, true, false, false, false, false, false}, {1}},
      {{false, false, true, false, false, false, false}, {0, 1, 2, 3, 4, 5}},
      {{false, false, false, true, true, false, true}, {0, 1, 2, 3, 6, 7}},
      {{true, false, false, false, false, true, false}, {0, 1, 2, 3, 4, 5, 6, 7}},
  };
  for (const auto& [chosen, blocks] : cases) {
    ConstraintSet all = make_constraints(kRods, x);
    LoopSystem system(scene.map, all, chosen);
    system.read(all, scene.configuration, x);
    REQUIRE(system.map().layout().block_count == static_cast<int32_t>(blocks.size()));
    const std::vector<double> residuals = all.residuals(x);
    CHECK(system.constraints().residuals(system.sites()) == system.part(residuals));
    CHECK(system.constraints().multipliers() == system.part(all.multipliers()));

    // Forces of the others are none.
    ConstraintSet::Inputs inputs = all.inputs();
    for (size_t r = 0; r < inputs.multipliers.size(); ++r)
      if (!chosen[r]) inputs.multipliers[r] = inputs.penalties[r] = 0.0;
    all.set_inputs(inputs);
    const std::vector<double> forces = gradient_of(scene.map, all, scene.configuration, x);
    const std::vector<double> found =
        gradient_of(system.map(), system.constraints(), system.configuration(), system.sites());
    double rest = 0.0;
    for (const double force : forces) rest += force * force;
    std::vector<double> step(forces.size()), step_here(found.size());
    std::mt19937_64 random(7);
    std::uniform_real_distribution<double> number(-0.1, 0.1);
    for (size_t i = 0; i < found.size(); ++i) {
      const size_t there = 3 * static_cast<size_t>(blocks[i / 3]) + i % 3;
      CHECK(found[i] == doctest::Approx(forces[there]).epsilon(1e-13));
      rest -= forces[there] * forces[there];
      step[there] = step_here[i] = number(random);
    }
    CHECK(std::fabs(rest) < 1e-9);

    Configuration moved, moved_here;
    scene.map.retract(scene.configuration, step, 1.0, KinematicMap::Way::Straight, moved);
    system.map().retract(system.configuration(), step_here, 1.0, KinematicMap::Way::Straight, moved_here);
    std::vector<Vec3> sites(system.sites().size());
    system.map().positions(moved_here, sites);
    CHECK(system.constraints().residuals(sites) == system.part(all.residuals(scene.positions(moved))));
  }
}

TEST_CASE("residuals of some joints are those that they have among all") {
  const Scene scene;
  const std::vector<Vec3> x = scene.positions(scene.configuration);
  const ConstraintSet all = make_constraints(kRods, x);
  const std::vector<double> residuals = all.residuals(x);
  for (int32_t first = 0; first < 7; ++first)
    for (int32_t count = 0; first + count <= 7; ++count)
      CHECK(all.residuals_of(first, count, x) ==
            std::vector<double>(residuals.begin() + first, residuals.begin() + first + count));
}
