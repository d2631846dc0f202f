// A plate that yields: the curvatures of a triangle, which its fold angles determine (theory eq. 13a), have
// plastic parts, by the criterion of von Mises for moments per length, m11^2 - m11 m22 + m22^2 + 3 m12^2 =
// m_y^2. Half the sum, half the difference of the curvatures and their twist are the axes of both the elastic
// energy and the criterion. [Save, Massonnet 1972, "Plastic Analysis and Design of Plates, Shells and Disks";
// theory eq. 13c]
#include <array>
#include <string>

#include <stark/models/shells/plate_angles.h>
#include <stark/models/yielding.h>

namespace stark::models {

namespace {

/// Stiffness and yield force of the curvatures (k11 + k22)/sqrt 2, (k11 - k22)/sqrt 2 and 2 k12 of an area.
struct PlateYield {
  std::array<Scalar, 3> stiffness, yield_force;
};

PlateYield plate_yield(const Scalar& D, const Scalar& nu, const Scalar& area, const Scalar& yield) {
  const Scalar rigidity = D * area, moment = yield * area;
  return {
      .stiffness = {rigidity * (1.0 + nu), rigidity * (1.0 - nu), rigidity * 0.5 * (1.0 - nu)},
      .yield_force = {moment * std::sqrt(2.0), moment * std::sqrt(2.0 / 3.0), moment * std::sqrt(1.0 / 3.0)}};
}

/// Curvature i of a unit fold angle k.
Scalar curvature_rate(PotentialBuilder& b, int i, int k) {
  return b.data("curvature" + std::to_string(i) + std::to_string(k), "1/m", "curvature of a unit fold angle");
}

PotentialDefinition plastic_plate(int hinges, bool curls = false) {
  PotentialDefinition definition = define_potential(
      "plastic_plate_" + std::to_string(hinges), 3 + hinges,
      "bending of a triangle with " + std::to_string(hinges) + " hinges as a plate that yields",
      [hinges, curls](PotentialBuilder& b) {
        const Scalar D = b.parameter("flexural_rigidity", "N m", "rigidity of the plate");
        const Scalar nu = b.parameter("poissons_ratio", "1", "Poisson's ratio", half_open_interval(0.0, 0.5));
        const Scalar yield = b.parameter("bending_yield_moment", "N", "moment per length at which it yields",
                                         positive_or_infinity());
        const Scalar hardening =
            b.parameter("bending_hardening", "N m", "growth of the yield moment with the plastic curvature",
                        non_negative());
        const Scalar area = b.data("area", "m^2", "area that the triangle stands for");
        const auto before = b.internal("plastic_curvature", {0.0, 0.0, 0.0}, "1/m",
                                       "plastic curvatures: sum and difference over the root of 2, twist");
        const Scalar p = b.internal("plastic_work", {0.0}, "J", "plastic work as without hardening")[0];
        const std::vector<Scalar> bend = plate_bend(b, hinges, curls);
        const PlateYield plate = plate_yield(D, nu, area, yield);
        std::array<Scalar, 3> trial;
        std::vector<YieldingStrain> strains;
        for (int i = 0; i < 3; ++i) {
          trial[i] = -before[i];
          for (int k = 0; k < hinges; ++k) trial[i] = trial[i] + curvature_rate(b, i, k) * bend[k];
          strains.push_back({square(trial[i]), plate.stiffness[i], plate.yield_force[i]});
        }
        const Yielding yields = yielding(strains, hardening / (area * square(yield)), p);
        std::vector<Scalar> after;
        for (int i = 0; i < 3; ++i) after.push_back(before[i] + trial[i] * (1.0 - yields.kept[i]));
        b.update("plastic_curvature", after);
        b.update("plastic_work", {p + yields.work});
        // What the curvatures leave of the elastic energy: next to nothing, see mechanics/plate_element.h.
        return yields.energy + D * plate_form(b, bend);
      });
  definition.sample = [hinges](std::mt19937_64& random) {  // far beyond yielding
    PotentialSample sample = sample_plate(hinges, random);
    sample.values["bending_yield_moment"] = {0.02};
    sample.values["bending_hardening"] = {0.2};
    sample.values["poissons_ratio"] = {0.3};
    for (int k = 0; k < hinges; ++k) sample.values["rest_angle" + std::to_string(k)] = {-1.0 - 0.2 * k};
    for (int i = 0; i < 3; ++i)
      for (int k = 0; k < hinges; ++k)
        sample.values["curvature" + std::to_string(i) + std::to_string(k)] = {(i == k ? 1.0 : 0.3) + 0.1 * i -
                                                                              0.05 * k};
    return sample;
  };
  return definition;
}

}  // namespace

PotentialDefinition curling_plastic_plate(int hinges) { return plastic_plate(hinges, true); }

PotentialDefinition plastic_plate_1() { return plastic_plate(1); }
PotentialDefinition plastic_plate_2() { return plastic_plate(2); }
PotentialDefinition plastic_plate_3() { return plastic_plate(3); }

}  // namespace stark::models
