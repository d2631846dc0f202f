// Hinges that yield: the fold angle of theory eq. 13 has a plastic part, which changes where the moment about
// the edge reaches the yield moment per length times the length of the edge. A crease stays. [theory eq. 13b]
#include <stark/models/shells/hinge.h>
#include <stark/models/yielding.h>

namespace stark::models {

PotentialDefinition plastic_bending() {
  PotentialDefinition definition =
      define_potential("plastic_bending", 4, "bending of hinges that yield", [](PotentialBuilder& b) {
        const Scalar k = b.parameter("bending_stiffness", "J", "bending stiffness");
        const Scalar yield = b.parameter("bending_yield_moment", "N", "moment per length at which it yields",
                                         positive_or_infinity());
        const Scalar hardening =
            b.parameter("bending_hardening", "N m", "growth of the yield moment with the plastic curvature",
                        non_negative());
        const auto before = b.internal("plastic_angle", {0.0}, "rad", "plastic part of the fold angle");
        const Scalar p = b.internal("plastic_work", {0.0}, "J", "plastic work as without hardening")[0];
        const Scalar weight = hinge_weight(b), squared_length = squared_norm(rest_hinge(b).edge);
        const Scalar theta = fold_angle(hinge_at(b, &PotentialBuilder::x));
        const Scalar trial = theta - b.data("rest_angle", "rad", "fold angle at rest") - before[0];
        // With the area 1/weight of the hinge, 1/(area yield^2) turns work into the curvature it is of.
        const Scalar H = hardening * weight / square(yield);
        const Yielding yields =
            yielding({{square(trial), k * weight * squared_length, yield * sqrt(squared_length)}}, H, p);
        b.update("plastic_angle", {before[0] + trial * (1.0 - yields.kept[0])});
        b.update("plastic_work", {p + yields.work});
        return yields.energy;
      });
  definition.sample = [](std::mt19937_64& random) {  // far beyond yielding: there a difference meets no kink
    PotentialSample sample = sample_hinge(random);
    sample.values = {{"bending_yield_moment", {0.05}}, {"bending_hardening", {0.2}}, {"rest_angle", {-1.5}}};
    return sample;
  };
  return definition;
}

}  // namespace stark::models
