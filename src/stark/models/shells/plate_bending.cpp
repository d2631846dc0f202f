// Bending of a triangle as a plate, in the fold angles of its hinges: E = D/2 sum_ij S_ij (theta_i -
// theta_i0) (theta_j - theta_j0), S of mechanics/plate_element.h. Damping: d/(2 h) of the same form of the
// change of the angles within the step. [theory eq. 13a]
#include <stark/models/shells/plate_angles.h>

namespace stark::models {

namespace {

PotentialDefinition plate_bending(int hinges, bool curls = false) {
  PotentialDefinition definition = define_potential(
      "plate_bending_" + std::to_string(hinges), 3 + hinges,
      "bending of a triangle with " + std::to_string(hinges) + " hinges as a plate",
      [hinges, curls](PotentialBuilder& b) {
        const Scalar D = b.parameter("flexural_rigidity", "N m", "rigidity of the plate");
        const Scalar d = b.parameter("bending_damping", "J s", "viscosity of the fold angle rate");
        std::vector<Scalar> turn;
        for (int k = 0; k < hinges; ++k)
          turn.push_back(plate_angle(k, [&](int i) { return b.x(i); }) -
                         plate_angle(k, [&](int i) { return b.x_prev(i); }));
        return D * plate_form(b, plate_bend(b, hinges, curls)) + d / b.time_step() * plate_form(b, turn);
      });
  definition.sample = [hinges](std::mt19937_64& random) { return sample_plate(hinges, random); };
  return definition;
}

}  // namespace

PotentialSample sample_plate(int hinges, std::mt19937_64& random) {
  std::uniform_real_distribution<double> noise(-0.1, 0.1);
  const std::vector<stark::Vec3> flat{{0, 0, 0},     {1, 0, 0},      {0.5, 0.9, 0},  {0.5, -0.8, 0},
                                      {1.4, 0.8, 0}, {-0.4, 0.9, 0}, {-0.4, -0.6, 0}};
  PotentialSample sample;
  for (int i = 0; i < 3 + hinges; ++i) {
    const stark::Vec3 p = flat[i] + stark::Vec3{noise(random), noise(random), noise(random)};
    sample.X.push_back(flat[i]);
    sample.x_prev.push_back(p);
    sample.x.push_back(p + stark::Vec3{0.5 * noise(random), 0.5 * noise(random), noise(random)});
  }
  for (int i = 0; i < hinges; ++i) {
    sample.values["rest_angle" + std::to_string(i)] = {noise(random)};
    for (int j = i; j < hinges; ++j)
      sample.values["form" + std::to_string(i) + std::to_string(j)] = {i == j ? 1.0 : 0.2};
  }
  return sample;
}

PotentialDefinition curling_plate(int hinges) { return plate_bending(hinges, true); }

PotentialDefinition plate_bending_1() { return plate_bending(1); }
PotentialDefinition plate_bending_2() { return plate_bending(2); }
PotentialDefinition plate_bending_3() { return plate_bending(3); }
PotentialDefinition plate_bending_4() { return plate_bending(4); }

}  // namespace stark::models
