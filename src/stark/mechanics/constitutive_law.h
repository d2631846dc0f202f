// Constitutive laws: stored energy per rest volume [J/m^3] as a formula of the deformation gradient F, apart
// from the element that supplies F. Built-in laws and those of users are the same thing. A law that uses F at
// the start of the step and the time step is viscous. Phase: model building.
//
//   SolidLaw st_venant_kirchhoff() {
//     return define_solid_law("st_venant_kirchhoff", "...", [](PotentialBuilder& b, const SolidDeformation&
//     d) {
//       const Mat3 E = 0.5 * (transpose(d.F()) * d.F() - Mat3::identity());
//       return b.parameter("shear_modulus", "Pa", "...", positive()) * squared_norm(E) + ...;
//     });
//   }
#pragma once

#include <functional>
#include <map>
#include <optional>
#include <random>
#include <string>
#include <vector>

#include <stark/mechanics/formula.h>
#include <stark/mechanics/potential.h>

namespace stark {

/// Deformation gradient of an element with `columns` material directions: 3x3 in solids, 3x2 in shells, whose
/// material frame is orthonormal in the rest triangle. Evaluated when asked for, so that a law without memory
/// has no inputs for the past.
template <int columns>
struct Deformation {
  using Gradient = symbolic::Mat<3, columns>;
  std::function<Gradient(PotentialBuilder::Position)> F_of;            ///< see PotentialBuilder::reference
  Gradient F() const { return F_of(&PotentialBuilder::x); }            ///< at the end of the step
  Gradient F_prev() const { return F_of(&PotentialBuilder::x_prev); }  ///< at the start of the step
};
using SolidDeformation = Deformation<3>;
using ShellDeformation = Deformation<2>;

template <int columns>
struct ConstitutiveLaw {
  std::string name;
  std::string doc;
  /// Energy per rest volume [J/m^3]. Of the builder use parameters, data, internal variables and time only:
  /// the points belong to the element. With internal variables it is the energy of the step, least in what
  /// the variables become [theory eq. 10b].
  std::function<symbolic::Scalar(PotentialBuilder&, const Deformation<columns>&)> psi;
  bool zero_at_rest = true;  ///< declared: no energy and no stress at F = F_prev = 1; checked by the sweep
  bool objective = true;     ///< declared: a rotation of space leaves psi unchanged; checked likewise
  /// Declared: the material directions are equivalent, so that any frame of a shell will do. Shells of other
  /// laws get the parameter `warp_direction`.
  bool isotropic = true;
  bool one_sided = false;  ///< declared, see PotentialDefinition
  /// Values of parameters for the automatic tests; those left out are in [0.5, 1.5].
  std::function<std::map<std::string, std::vector<double>>(std::mt19937_64&)> sample;
};
using SolidLaw = ConstitutiveLaw<3>;
using ShellLaw = ConstitutiveLaw<2>;

SolidLaw define_solid_law(std::string name, std::string doc,
                          std::function<symbolic::Scalar(PotentialBuilder&, const SolidDeformation&)> psi);
ShellLaw define_shell_law(std::string name, std::string doc,
                          std::function<symbolic::Scalar(PotentialBuilder&, const ShellDeformation&)> psi);

/// Laws whose psi is the first output of a formula of 3 (shells: 2) points: the columns of F; the others are
/// the updates of its internal variables; x_prev are those of F_prev. Throws InvalidArgument for another
/// number of points. Rest positions mean nothing to a law: X and x_initial of the formula become the columns
/// of the identity.
SolidLaw solid_law_from(std::string name, std::string doc, Formula formula);
ShellLaw shell_law_from(std::string name, std::string doc, Formula formula);

/// Sum of laws, for instance of an elastic and a viscous one; parameters of the same name are one.
SolidLaw sum(std::string name, const std::vector<SolidLaw>& laws);
ShellLaw sum(std::string name, const std::vector<ShellLaw>& laws);

/// Linear tetrahedron: 4 points, psi times rest volume.
PotentialDefinition tet4(const SolidLaw& law);

/// Quadrature point of a solid element: 3 points that stand for the columns of F, psi times the data
/// kQuadratureWeight [m^3]. What mechanics/quadrature_batch evaluates.
inline constexpr const char* kQuadratureWeight = "quadrature_weight";
PotentialDefinition quadrature_point(const SolidLaw& law);

/// Quadrature point of an element of mean dilatation: 4 points, the columns of F and (theta, 0, 0) with the
/// volume ratio theta of the element at the point. The law sees F with the determinant theta,
/// (theta / det F)^(1/3) F; `damping`, where there is one, F itself. [theory eq. 15b]
PotentialDefinition mean_dilatation_point(const SolidLaw& law, const std::optional<SolidLaw>& damping = {});

/// det F of 3 points, the columns of F.
PotentialDefinition volume_ratio();

/// Linear triangle of a shell: 3 points, psi times rest area times the parameter `thickness` [m]. Unless the
/// law is isotropic, the first axis of F is the parameter `warp_direction`, in the frame of the rest mesh,
/// projected into the rest triangle.
PotentialDefinition triangle3(const ShellLaw& law);

/// Whether `direction` has a projection into the triangle: false where it is normal to it within rounding.
bool is_projectable(const Vec3& direction, const Vec3& X0, const Vec3& X1, const Vec3& X2);

}  // namespace stark
