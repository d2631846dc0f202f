// Kirchhoff's rod with stretch that yields: axial force N, bending moments M and torque T stay within
// (N/N_y)^2 + (M_1/M_y1)^2 + (M_2/M_y2)^2 + (T/T_y)^2 = (1 + H p)^2, and what is beyond becomes plastic
// stretch, curvature and twist by the associated flow. The ellipsoid is that of fully plastic sections in
// bending and twist [Hill 1950, "The Mathematical Theory of Plasticity"; models/yielding.h; theory eq. 30a]
#include <stark/models/yielding.h>

namespace stark::models {

RodLaw plastic_rod() {
  RodLaw law = define_rod_law(
      "plastic_rod", "stretch, bending and twist that yield",
      [](PotentialBuilder& b, const RodDeformation& deformation) {
        const RodStrain s = deformation.strain();
        const std::array<Scalar, 4> stiffness{
            b.parameter("axial_stiffness", "N", "force for unit stretch", positive()),
            b.parameter("bending_stiffness_1", "N m^2", "bending stiffness about the first axis", positive()),
            b.parameter("bending_stiffness_2", "N m^2", "bending stiffness about the second axis",
                        positive()),
            b.parameter("torsional_stiffness", "N m^2", "torque for a twist of 1 rad/m", positive())};
        const FieldRule rule = positive_or_infinity();
        const std::array<Scalar, 4> yield_force{
            b.parameter("yield_force", "N", "axial force at which it yields", rule),
            b.parameter("yield_moment_1", "N m", "moment about the first axis at which it yields", rule),
            b.parameter("yield_moment_2", "N m", "moment about the second axis at which it yields", rule),
            b.parameter("yield_torque", "N m", "torque at which it yields", rule)};
        const Scalar H = b.parameter("yield_hardening", "m/J",
                                     "growth of what it yields at, as a factor, per plastic work and length",
                                     non_negative());
        const auto before = b.internal("plastic_strain", {0.0, 0.0, 0.0, 0.0}, "1, 1/m",
                                       "plastic stretch, curvatures and twist");
        const Scalar p = b.internal("plastic_work", {0.0}, "J/m", "plastic work as without hardening")[0];
        const std::array<Scalar, 4> strain{s.stretch - 1.0, s.curvature[0], s.curvature[1], s.twist};
        std::vector<YieldingStrain> trial;
        for (size_t i = 0; i < 4; ++i)
          trial.push_back({square(strain[i] - before[i]), stiffness[i], yield_force[i]});
        const Yielding yields = yielding(trial, H, p);
        std::vector<Scalar> after;
        for (size_t i = 0; i < 4; ++i)
          after.push_back(before[i] + (strain[i] - before[i]) * (1.0 - yields.kept[i]));
        b.update("plastic_strain", after);
        b.update("plastic_work", {p + yields.work});
        return yields.energy;
      });
  law.sample = [](std::mt19937_64&) {  // far beyond yielding: there a difference meets no kink
    return std::map<std::string, std::vector<double>>{{"yield_force", {5e-3}},
                                                      {"yield_moment_1", {4e-3}},
                                                      {"yield_moment_2", {6e-3}},
                                                      {"yield_torque", {5e-3}},
                                                      {"yield_hardening", {0.3}}};
  };
  return law;
}

}  // namespace stark::models
