// Strain limiting of edges: E = V k/3 max(0, |e|/L - 1 - limit)^3, C2 at the limit, V the volume that the
// edge stands for. [paper sec. IV-A: "edge-length based strain limiting"] For cloth and solids alike.
// [theory eq. 14a]
#include <stark/mechanics/define.h>
#include <stark/mechanics/rest_state.h>

namespace stark::models {

namespace {

/// rest: what the edge is without load.
Scalar limit_energy(PotentialBuilder& b, const rest_state::GrownEdge& rest) {
  const Scalar volume = b.data("volume", "m^3", "volume that the edge stands for");
  const Scalar limit = b.parameter("strain_limit", "1", "stretch beyond which the penalty acts");
  const Scalar k = b.parameter("strain_limit_stiffness", "Pa", "stiffness of the penalty");
  const Scalar strain = norm(b.x(1) - b.x(0)) / norm(rest.vector) - 1.0;
  const Scalar excess = max(strain - limit, 0.0);
  return rest.volume_ratio * volume * k / 3.0 * excess * excess * excess;
}

}  // namespace

/// Of an element whose rest shape changes (mechanics/rest_state.h) by growth and temperature.
PotentialDefinition grown_edge_strain_limit(const std::set<std::string>& fields, bool is_solid) {
  return define_potential("grown_edge_strain_limit", 2, "strain limiting of edges of what grows",
                          [fields, is_solid](PotentialBuilder& b) {
                            return limit_energy(b,
                                                rest_state::grown_edge(b, fields, b.X(1) - b.X(0), is_solid));
                          });
}

PotentialDefinition edge_strain_limit() {
  PotentialDefinition definition =
      define_potential("edge_strain_limit", 2, "strain limiting of edges",
                       [](PotentialBuilder& b) { return limit_energy(b, {b.X(1) - b.X(0), 1.0}); });
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
