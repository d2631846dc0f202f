// Laws as formulas and the linear elements that evaluate them. See constitutive_law.h.
#include <stark/mechanics/constitutive_law.h>

#include <stark/base/error.h>

namespace stark {

using symbolic::Scalar;

namespace {

// Sine of the smallest angle between a direction and the normal of a triangle at which the projection still
// has about nine digits.
constexpr double kSmallestProjection = 1e-6;

template <int columns>
ConstitutiveLaw<columns> define_law(
    std::string name, std::string doc,
    std::function<Scalar(PotentialBuilder&, const Deformation<columns>&)> psi) {
  ConstitutiveLaw<columns> law;
  law.name = std::move(name);
  law.doc = std::move(doc);
  law.psi = std::move(psi);
  return law;
}

template <int columns>
std::vector<symbolic::Vec3> columns_of(const symbolic::Mat<3, columns>& F) {
  std::vector<symbolic::Vec3> result;
  for (int j = 0; j < columns; ++j) result.push_back(F.column(j));
  return result;
}

template <int columns>
ConstitutiveLaw<columns> law_from(std::string name, std::string doc, Formula formula) {
  if (formula.point_count() != columns)
    throw InvalidArgument("law '" + name + "': its formula has " + std::to_string(formula.point_count()) +
                          " points: must have " + std::to_string(columns) +
                          ", the columns of the deformation gradient");
  const bool remembers = formula.uses(ElementField::Source::Previous);
  auto law = define_law<columns>(std::move(name), std::move(doc),
                                 [formula = std::move(formula), remembers](
                                     PotentialBuilder& b, const Deformation<columns>& deformation) {
                                   symbolic::Mat<3, columns> identity;
                                   for (int i = 0; i < columns; ++i) identity(i, i) = 1.0;
                                   PointExpressions points{.x = columns_of(deformation.F()),
                                                           .X = columns_of(identity),
                                                           .x_initial = columns_of(identity)};
                                   points.x_prev = remembers ? columns_of(deformation.F_prev()) : points.x;
                                   return formula.repeat_energy(b, points);
                                 });
  law.zero_at_rest = law.objective = law.isotropic = false;  // nobody has promised it
  return law;
}

template <int columns>
ConstitutiveLaw<columns> sum_of(std::string name, const std::vector<ConstitutiveLaw<columns>>& laws) {
  STARK_CHECK(!laws.empty());
  ConstitutiveLaw<columns> total = laws.front();
  total.name = std::move(name);
  total.psi = [laws](PotentialBuilder& b, const Deformation<columns>& deformation) {
    Scalar psi = laws.front().psi(b, deformation);
    for (size_t k = 1; k < laws.size(); ++k) psi = psi + laws[k].psi(b, deformation);
    return psi;
  };
  for (const ConstitutiveLaw<columns>& law : laws) {
    total.zero_at_rest = total.zero_at_rest && law.zero_at_rest;
    total.objective = total.objective && law.objective;
    total.isotropic = total.isotropic && law.isotropic;
    total.one_sided = total.one_sided && law.one_sided;
  }
  return total;
}

/// What an element inherits from its law.
template <int columns>
PotentialDefinition element_of(const ConstitutiveLaw<columns>& law, int points, const std::string& element,
                               std::function<Scalar(PotentialBuilder&)> energy) {
  PotentialDefinition definition =
      define_potential(law.name, points, law.doc + " of " + element, std::move(energy));
  definition.zero_at_rest = law.zero_at_rest;
  definition.rotation_invariant = law.objective;
  definition.one_sided = law.one_sided;
  if (law.sample)
    definition.sample = [sample = law.sample](std::mt19937_64& random) {
      PotentialSample result;
      result.values = sample(random);
      return result;
    };
  return definition;
}

using Point = PotentialBuilder::Position;

symbolic::Mat3 tet_edges(PotentialBuilder& b, Point p) {
  const symbolic::Vec3 p0 = (b.*p)(0), p1 = (b.*p)(1), p2 = (b.*p)(2), p3 = (b.*p)(3);
  return symbolic::Mat3::from_columns(p1 - p0, p2 - p0, p3 - p0);
}

symbolic::Mat32 triangle_edges(PotentialBuilder& b, Point p) {
  const symbolic::Vec3 p0 = (b.*p)(0), p1 = (b.*p)(1), p2 = (b.*p)(2);
  return symbolic::Mat32::from_columns(p1 - p0, p2 - p0);
}

/// Rest edges in an orthonormal frame of their plane whose first axis is the projection of `direction`.
symbolic::Mat2 edges_in_frame(const symbolic::Mat32& edges, const symbolic::Vec3& direction) {
  const symbolic::Vec3 normal = normalized(cross(edges.column(0), edges.column(1)));
  const symbolic::Vec3 warp = normalized(direction - dot(direction, normal) * normal);
  const symbolic::Vec3 weft = cross(normal, warp);
  return {dot(warp, edges.column(0)), dot(warp, edges.column(1)), dot(weft, edges.column(0)),
          dot(weft, edges.column(1))};
}

}  // namespace

SolidLaw define_solid_law(std::string name, std::string doc,
                          std::function<Scalar(PotentialBuilder&, const SolidDeformation&)> psi) {
  return define_law<3>(std::move(name), std::move(doc), std::move(psi));
}

ShellLaw define_shell_law(std::string name, std::string doc,
                          std::function<Scalar(PotentialBuilder&, const ShellDeformation&)> psi) {
  return define_law<2>(std::move(name), std::move(doc), std::move(psi));
}

SolidLaw solid_law_from(std::string name, std::string doc, Formula formula) {
  return law_from<3>(std::move(name), std::move(doc), std::move(formula));
}

ShellLaw shell_law_from(std::string name, std::string doc, Formula formula) {
  return law_from<2>(std::move(name), std::move(doc), std::move(formula));
}

SolidLaw sum(std::string name, const std::vector<SolidLaw>& laws) { return sum_of(std::move(name), laws); }

ShellLaw sum(std::string name, const std::vector<ShellLaw>& laws) { return sum_of(std::move(name), laws); }

PotentialDefinition tet4(const SolidLaw& law) {
  return element_of(law, 4, "linear tetrahedra", [psi = law.psi](PotentialBuilder& b) {
    const auto gradient = [&b](Point p) {
      return tet_edges(b, p) * inverse(tet_edges(b, &PotentialBuilder::X));
    };
    const SolidDeformation deformation{gradient};
    const Scalar density = psi(b, deformation);
    return density * (determinant(tet_edges(b, &PotentialBuilder::X)) / 6.0);
  });
}

PotentialDefinition quadrature_point(const SolidLaw& law) {
  PotentialDefinition definition =
      element_of(law, 3, "quadrature points", [psi = law.psi](PotentialBuilder& b) {
        const auto gradient = [&b](Point p) {
          return symbolic::Mat3::from_columns((b.*p)(0), (b.*p)(1), (b.*p)(2));
        };
        const SolidDeformation deformation{gradient};
        const Scalar density = psi(b, deformation);
        return density * b.data(kQuadratureWeight, "m^3", "rest volume that the point stands for");
      });
  definition.translation_invariant = definition.zero_at_rest = false;  // the points are no places
  return definition;
}

PotentialDefinition mean_dilatation_point(const SolidLaw& law, const std::optional<SolidLaw>& damping) {
  PotentialDefinition definition =
      element_of(law, 4, "points of mean dilatation", [psi = law.psi, damping](PotentialBuilder& b) {
        const auto gradient = [&b](Point p) {
          return symbolic::Mat3::from_columns((b.*p)(0), (b.*p)(1), (b.*p)(2));
        };
        const auto scaled = [&](Point p) {
          const symbolic::Mat3 F = gradient(p);
          return F * pow((b.*p)(3)[0] / determinant(F), 1.0 / 3.0);
        };
        Scalar density = psi(b, SolidDeformation{scaled});
        if (damping) density = density + damping->psi(b, SolidDeformation{gradient});
        return density * b.data(kQuadratureWeight, "m^3", "rest volume that the point stands for");
      });
  definition.translation_invariant = definition.zero_at_rest = false;  // the points are no places
  definition.one_sided = false;
  return definition;
}

PotentialDefinition volume_ratio() {
  PotentialDefinition definition = define_potential(
      "volume_ratio", 3, "volume over that at rest",
      [](PotentialBuilder& b) { return determinant(symbolic::Mat3::from_columns(b.x(0), b.x(1), b.x(2))); });
  definition.translation_invariant = false;
  return definition;
}

PotentialDefinition triangle3(const ShellLaw& law) {
  return element_of(law, 3, "triangles", [psi = law.psi, isotropic = law.isotropic](PotentialBuilder& b) {
    const symbolic::Mat32 rest = triangle_edges(b, &PotentialBuilder::X);
    const symbolic::Mat2 edges = edges_in_frame(
        rest, isotropic ? rest.column(0)
                        : b.direction("warp_direction", "first axis of the cloth, in the rest mesh"));
    const auto gradient = [&](Point p) { return triangle_edges(b, p) * inverse(edges); };
    const ShellDeformation deformation{gradient};
    const Scalar density = psi(b, deformation);
    return density * b.parameter("thickness", "m", "thickness of the sheet", positive()) * 0.5 *
           determinant(edges);
  });
}

bool is_projectable(const Vec3& direction, const Vec3& X0, const Vec3& X1, const Vec3& X2) {
  const Vec3 normal = cross(X1 - X0, X2 - X0);
  const double sine = norm(cross(direction, normal));
  return sine > kSmallestProjection * norm(direction) * norm(normal);
}

}  // namespace stark
