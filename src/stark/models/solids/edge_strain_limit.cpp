// Strain limiting of edges: E = V k/3 max(0, |e|/L - 1 - limit)^3, C2 at the limit, V the volume that the
// edge stands for. [paper sec. IV-A: "edge-length based strain limiting"] For cloth and solids alike.
// [theory eq. 14a]
#include <stark/mechanics/define.h>

namespace stark::models {

PotentialDefinition edge_strain_limit() {
  PotentialDefinition definition =
      define_potential("edge_strain_limit", 2, "strain limiting of edges", [](PotentialBuilder& b) {
        const Scalar volume = b.data("volume", "m^3", "volume that the edge stands for");
        const Scalar limit = b.parameter("strain_limit", "1", "stretch beyond which the penalty acts");
        const Scalar k = b.parameter("strain_limit_stiffness", "Pa", "stiffness of the penalty");
        const Scalar strain = norm(b.x(1) - b.x(0)) / norm(b.X(1) - b.X(0)) - 1.0;
        const Scalar excess = max(strain - limit, 0.0);
        return volume * k / 3.0 * excess * excess * excess;
      });
  definition.zero_at_rest = true;
  definition.one_sided = true;
  definition.sample = [](std::mt19937_64& random) {
    std::uniform_real_distribution<double> stretch(0.8, 1.6);
    PotentialSample sample;
    sample.X = {{0, 0, 0}, {1, 0.2, -0.3}};
    sample.x = {{0.1, 0.2, 0.3}, {0.1 + stretch(random), 0.5, 0.0}};
    sample.x_prev = sample.X;
    sample.values["strain_limit"] = {0.1};
    return sample;
  };
  return definition;
}

}  // namespace stark::models
