// Laws of rods and the segment that evaluates them. See rod_law.h.
#include <stark/mechanics/rod_law.h>

#include <stark/base/error.h>
#include <stark/base/rotation.h>

namespace stark {

using symbolic::Scalar;

namespace {

using Point = PotentialBuilder::Position;

/// 4 cos^2(phi/2) of turns within a segment by 162 degrees.
constexpr double kLeastTurnCosine = 0.1;

/// Edge in the middle of a segment and turn of its frames; not yet per rest length.
struct SegmentStrain {
  symbolic::Vec3 edge_in_frame;  ///< [m] along m1, m2, m3
  symbolic::Vec3 turn;           ///< (tan(phi/2) + sin(phi/2)) n along d1, d2, d3
};

/// 4 cos^2(phi/2), by the trace of R0^T R1.
Scalar turn_cosine(PotentialBuilder& b, Point p) {
  const auto Q = [&](int k) { return dot((b.*p)(2 + k), (b.*p)(5 + k)); };
  return 1.0 + Q(0) + Q(1) + Q(2);
}

SegmentStrain segment_strain(PotentialBuilder& b, Point p) {
  const symbolic::Vec3 edge = (b.*p)(1) - (b.*p)(0);
  const auto axis = [&](int node, int k) { return (b.*p)(2 + 3 * node + k); };
  // Q = R0^T R1 has the axial vector sin(phi) n and the trace 1 + 2 cos(phi);
  // c = cos(phi/2) and w = sin(phi/2) n.
  const auto Q = [&](int i, int j) { return dot(axis(0, i), axis(1, j)); };
  const Scalar c = 0.5 * sqrt(turn_cosine(b, p));
  const symbolic::Vec3 axial(Q(2, 1) - Q(1, 2), Q(0, 2) - Q(2, 0), Q(1, 0) - Q(0, 1));
  const symbolic::Vec3 w = axial * (0.25 / c);
  // Rodrigues: what is a in the first frame is turned back by phi/2 into the middle.
  const symbolic::Vec3 a(dot(edge, axis(0, 0)), dot(edge, axis(0, 1)), dot(edge, axis(0, 2)));
  return {.edge_in_frame = a * c - cross(w, a) + w * (dot(w, a) / (1.0 + c)), .turn = w * (1.0 / c + 1.0)};
}

Scalar rest_length(PotentialBuilder& b) { return norm(b.X(1) - b.X(0)); }

RodStrain strain_of(PotentialBuilder& b, Point p) {
  const SegmentStrain now = segment_strain(b, p), rest = segment_strain(b, &PotentialBuilder::X);
  const Scalar inverse_length = 1.0 / rest_length(b);
  const Scalar stretch = norm((b.*p)(1) - (b.*p)(0)) * inverse_length;
  const auto turn = [&](int k) { return (now.turn[k] - rest.turn[k]) * inverse_length; };
  return {.stretch = stretch,
          .shear = (now.edge_in_frame - rest.edge_in_frame * stretch) * inverse_length,
          .curvature = {turn(0), turn(1)},
          .twist = turn(2)};
}

/// PotentialBuilder::reference of all strains. Frames that turn fast are extrapolated column by column, and
/// are then not orthonormal: they may have no strain. The strain of the end stands for it, so the rate is 0.
RodStrain reference_strain(PotentialBuilder& b) {
  using Vector = symbolic::Vec3;
  const auto reference = [&](auto&& part) {
    return b.reference([&](Point p) { return part(strain_of(b, p)); });
  };
  const Vector bending =
      reference([](const RodStrain& s) { return Vector(s.curvature[0], s.curvature[1], s.twist); });
  const Vector shear = reference([](const RodStrain& s) { return s.shear; });
  const RodStrain now = strain_of(b, &PotentialBuilder::x);
  const Scalar least =
      min(turn_cosine(b, &PotentialBuilder::x_prev),
          min(turn_cosine(b, &PotentialBuilder::x_beyond), turn_cosine(b, &PotentialBuilder::x_behind)));
  const symbolic::Scalar is_known = least > kLeastTurnCosine;
  const Vector turn = select(is_known, bending, Vector(now.curvature[0], now.curvature[1], now.twist));
  return {.stretch = reference([](const RodStrain& s) { return s.stretch; }),
          .shear = select(is_known, shear, now.shear),
          .curvature = {turn[0], turn[1]},
          .twist = turn[2]};
}

std::vector<symbolic::Vec3> points_of(const RodStrain& strain) {
  return {symbolic::Vec3(0.0, 0.0, strain.stretch),
          symbolic::Vec3(strain.curvature[0], strain.curvature[1], strain.twist)};
}

/// A segment of about a metre, moderately bent, twisted, stretched and sheared.
PotentialSample sample_segment(std::mt19937_64& random) {
  std::uniform_real_distribution<double> small(-0.2, 0.2);
  const auto shape = [&](double amount) {
    const auto vector = [&] { return Vec3{small(random), small(random), small(random)} * amount; };
    std::vector<Vec3> points{vector(), Vec3{0, 0, 1.0} + vector()};
    for (int node = 0; node < 2; ++node) {
      const Mat3 R = exp_rotation(vector());
      for (int k = 0; k < 3; ++k) points.push_back(R.column(k));
    }
    return points;
  };
  return {.X = shape(0.5), .x_prev = shape(1.0), .x = shape(1.0), .values = {}};
}

}  // namespace

RodLaw define_rod_law(std::string name, std::string doc,
                      std::function<Scalar(PotentialBuilder&, const RodDeformation&)> psi) {
  return {.name = std::move(name), .doc = std::move(doc), .psi = std::move(psi)};
}

RodLaw rod_law_from(std::string name, std::string doc, Formula formula) {
  if (formula.point_count() != 2)
    throw InvalidArgument("rod law '" + name + "': its formula has " + std::to_string(formula.point_count()) +
                          " points: must have 2, for stretch and for curvature and twist");
  const bool remembers = formula.uses(ElementField::Source::Previous);
  RodLaw law = define_rod_law(
      std::move(name), std::move(doc),
      [formula = std::move(formula), remembers](PotentialBuilder& b, const RodDeformation& deformation) {
        PointExpressions points{.x = points_of(deformation.strain())};
        points.X = points.x_initial = {symbolic::Vec3(0.0, 0.0, 1.0), symbolic::Vec3(0.0, 0.0, 0.0)};
        points.x_prev = remembers ? points_of(deformation.strain_prev()) : points.x;
        return formula.repeat_energy(b, points);
      });
  law.zero_at_rest = false;  // nobody has promised it
  return law;
}

RodLaw sum(std::string name, const std::vector<RodLaw>& laws) {
  STARK_CHECK(!laws.empty());
  RodLaw total = laws.front();
  total.name = std::move(name);
  total.psi = [laws](PotentialBuilder& b, const RodDeformation& deformation) {
    Scalar psi = laws.front().psi(b, deformation);
    for (size_t k = 1; k < laws.size(); ++k) psi = psi + laws[k].psi(b, deformation);
    return psi;
  };
  for (const RodLaw& law : laws) total.zero_at_rest = total.zero_at_rest && law.zero_at_rest;
  return total;
}

PotentialDefinition rod_segment(const RodLaw& law) {
  PotentialDefinition definition = define_potential(
      law.name, kRodSegmentPoints, law.doc + " of segments", [psi = law.psi](PotentialBuilder& b) {
        const RodDeformation deformation{[&] { return strain_of(b, &PotentialBuilder::x); },
                                         [&] { return reference_strain(b); }};
        const Scalar density = psi(b, deformation);
        const RodStrain strain = deformation.strain();
        const Scalar k =
            b.parameter("shear_stiffness", "N", "force for unit shear of the section", positive());
        const Scalar shear = 0.5 * k * squared_norm(strain.shear);
        return rest_length(b) * (density + shear);
      });
  definition.translation_invariant = false;  // six of the points are directions
  definition.zero_at_rest = law.zero_at_rest;
  definition.sample = [values = law.sample](std::mt19937_64& random) {
    PotentialSample sample = sample_segment(random);
    if (values) sample.values = values(random);
    return sample;
  };
  return definition;
}

PotentialDefinition rod_bar(const RodLaw& law) {
  PotentialDefinition definition =
      define_potential(law.name, 2, law.doc + " of bars", [psi = law.psi](PotentialBuilder& b) {
        const auto stretch = [&](Point p) {
          return RodStrain{.stretch = norm((b.*p)(1) - (b.*p)(0)) / rest_length(b),
                           .shear = symbolic::Vec3(0.0, 0.0, 0.0),
                           .curvature = {0.0, 0.0},
                           .twist = 0.0};
        };
        const RodDeformation deformation{[&] { return stretch(&PotentialBuilder::x); },
                                         [&] { return stretch(&PotentialBuilder::x_prev); }};
        return rest_length(b) * psi(b, deformation);
      });
  definition.zero_at_rest = law.zero_at_rest;
  return definition;
}

}  // namespace stark
