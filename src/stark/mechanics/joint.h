// A joint: residuals between two frames that are held at zero, and coordinates of the motion that is left.
// Written once as a formula, for rigid bodies, patches of deformable ones and the world alike:
//
//   JointDefinition hinge() {
//     return define_joint("hinge", "...", [](JointBuilder& j) {
//       j.hold(j.a.origin - j.b.origin, ResidualUnit::Length);
//       j.hold(j.a.z - j.b.z, ResidualUnit::Angle);
//       j.coordinate("angle", atan2(dot(j.b.x, j.a.y), dot(j.b.x, j.a.x)), "rad");
//     });
//   }
//
// The residuals C become the augmented Lagrangian sum_k lambda_k C_k + rho_k/2 C_k^2, an energy like any
// other (mechanics/constraint_set.h updates lambda and rho). Limits C <= 0 have the one-sided form
// (max(0, lambda + rho C)^2 - lambda^2) / (2 rho) [Rockafellar 1973; theory eq. 38]. Phase: model building.
#pragma once

#include <functional>
#include <string>
#include <vector>

#include <stark/mechanics/field_values.h>
#include <stark/mechanics/formula.h>
#include <stark/symbolic/evaluate.h>

namespace stark {

/// What a residual measures, and so which of the two tolerances of a joint it is held to. Differences of unit
/// vectors count as angles.
enum class ResidualUnit : uint8_t { Length, Angle };

/// What carries a frame: a rigid body or the world (a point and three directions), the same with a place
/// there that may change between steps, or three vertices.
enum class FrameKind : uint8_t { Axes, Placed, Patch };
constexpr int frame_point_count(FrameKind kind) { return kind == FrameKind::Patch ? 3 : 4; }

/// Numbers of a Placed frame, as its carrier sees it: position [m], and the nine entries of its rotation, row
/// by row.
inline constexpr int kPlaceNumbers = 12;

/// Numbers that place a frame on a patch: three barycentric weights, height above it [m], and the nine
/// entries of the rotation from the frame to the axes of the patch (patch_axes), row by row.
inline constexpr int kPatchNumbers = 13;

/// Axes of a triangle as columns: along its first edge, across it, normal to it.
symbolic::Mat3 patch_axes(const symbolic::Vec3& p0, const symbolic::Vec3& p1, const symbolic::Vec3& p2);

/// Origin [m] and unit axes of a frame, in the world.
struct FrameExpressions {
  symbolic::Vec3 origin, x, y, z;
};

/// A residual and what holds it.
struct ConstraintRow {
  symbolic::Scalar residual, multiplier, penalty;
};
/// Augmented Lagrangian of a residual, and its derivative by the residual.
symbolic::Scalar constraint_energy(const ConstraintRow& row, bool one_sided);
symbolic::Scalar constraint_force(const ConstraintRow& row, bool one_sided);

class JointBuilder {
 public:
  JointBuilder(PotentialBuilder& builder, FrameKind kind_a, FrameKind kind_b);

  FrameExpressions a, b;                  ///< now
  FrameExpressions a_prev, b_prev;        ///< at the start of the step
  FrameExpressions a_initial, b_initial;  ///< at time 0

  /// Residuals to be held at zero.
  void hold(const symbolic::Scalar& residual, ResidualUnit unit);
  void hold(const symbolic::Vec3& residual, ResidualUnit unit);
  void hold(std::span<const symbolic::Scalar> residuals, ResidualUnit unit);
  /// A residual that is kept at or below zero: a stop.
  void limit(const symbolic::Scalar& residual, ResidualUnit unit);
  /// A coordinate of the joint. Coordinates in rad may jump by full turns: they are unwrapped in time
  /// (theory eq. 32).
  void coordinate(const std::string& name, const symbolic::Scalar& value, const std::string& unit);

  /// Constants of the joint, as in PotentialBuilder.
  symbolic::Scalar parameter(const std::string& name, const std::string& unit, const std::string& doc);
  symbolic::Vec3 parameter3(const std::string& name, const std::string& unit, const std::string& doc);

  PotentialBuilder& inputs() { return builder_; }
  struct Coordinate {
    std::string name, unit;
    symbolic::Scalar value;
  };
  const std::vector<symbolic::Scalar>& residuals() const { return residuals_; }
  const std::vector<ResidualUnit>& units() const { return units_; }
  const std::vector<int>& hold_sizes() const { return hold_sizes_; }
  const std::vector<char>& one_sided() const { return one_sided_; }
  const std::vector<Coordinate>& coordinates() const { return coordinates_; }

 private:
  PotentialBuilder& builder_;
  std::vector<symbolic::Scalar> residuals_;
  std::vector<ResidualUnit> units_;
  std::vector<int> hold_sizes_;
  std::vector<char> one_sided_;
  std::vector<Coordinate> coordinates_;
};

struct JointDefinition {
  std::string name;
  std::string doc;
  std::function<void(JointBuilder&)> formula;
};

JointDefinition define_joint(std::string name, std::string doc, std::function<void(JointBuilder&)> formula);

/// What the outputs of a formula mean as a joint: residuals, hold by hold, then coordinates.
struct JointOutputs {
  struct Hold {
    ResidualUnit unit = ResidualUnit::Length;
    int count = 1;
  };
  struct Coordinate {
    std::string name, unit;
  };
  std::vector<Hold> holds{};
  std::vector<Coordinate> coordinates{};
};

/// Joint from a formula of eight points: origin and axes x, y, z of frame a, then of frame b.
JointDefinition define_joint(std::string name, std::string doc, Formula formula, JointOutputs outputs);

/// A compiled joint between two kinds of frames. Immutable; shared by all joints of the definition.
class Joint {
 public:
  Joint(const JointDefinition& definition, FrameKind kind_a, FrameKind kind_b, symbolic::Backend backend);

  const std::string& name() const { return name_; }
  FrameKind kind_a() const { return kind_a_; }
  FrameKind kind_b() const { return kind_b_; }
  /// Which points of the two frames the formula uses: 0.. of frame a, then those of frame b.
  const std::vector<int>& points() const { return points_; }
  const std::vector<ResidualUnit>& units() const { return units_; }  ///< by residual
  /// Residuals of each hold(): the norm of so many in a row is what a tolerance bounds.
  const std::vector<int>& hold_sizes() const { return hold_sizes_; }
  using Coordinate = JointOutputs::Coordinate;
  const std::vector<Coordinate>& coordinates() const { return coordinates_; }

  /// By residual: kept at or below zero instead of at zero.
  const std::vector<char>& one_sided() const { return one_sided_; }

  /// Element data "multiplier" and "penalty" (a number for each residual), and what the formula declares.
  const std::shared_ptr<const Potential>& potential() const { return potential_; }
  /// Residuals, then coordinates; inputs as the kernel of potential().
  const symbolic::Function& values() const { return values_; }

 protected:
  Joint() = default;

  std::string name_;
  FrameKind kind_a_ = FrameKind::Axes, kind_b_ = FrameKind::Axes;
  std::vector<int> points_;
  std::vector<ResidualUnit> units_;
  std::vector<int> hold_sizes_;
  std::vector<char> one_sided_;
  std::vector<Coordinate> coordinates_;
  std::shared_ptr<const Potential> potential_;
  symbolic::Function values_;
};

/// Inputs that a joint's formula declares, other than the placement of patches.
std::vector<ParameterDeclaration> joint_parameters(const JointDefinition& definition);
/// Coordinates that it has.
std::vector<JointOutputs::Coordinate> joint_coordinates(const JointDefinition& definition);

}  // namespace stark
