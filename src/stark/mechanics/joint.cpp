#include <stark/mechanics/joint.h>

#include <set>

#include <stark/base/error.h>
#include <stark/mechanics/reduced_formula.h>

namespace stark {

using symbolic::Scalar;
using SymbolicVec3 = symbolic::Vec3;

namespace {

/// Frame whose points start at `first`; `at` says whether they are taken now or at the start of the step.
FrameExpressions frame_of(PotentialBuilder& builder, FrameKind kind, int first, const std::string& placement,
                          SymbolicVec3 (PotentialBuilder::*at)(int)) {
  const auto point = [&](int k) { return (builder.*at)(first + k); };
  if (kind == FrameKind::Axes) return {point(0), point(1), point(2), point(3)};
  if (kind == FrameKind::Placed) {
    const std::vector<Scalar> n = builder.data_array(placement, kPlaceNumbers, "",
                                                     "place on what carries the frame: position, rotation");
    const symbolic::Mat3 carrier = symbolic::Mat3::from_columns(point(1), point(2), point(3));
    const symbolic::Mat3 turned =
        carrier * symbolic::Mat3(n[3], n[4], n[5], n[6], n[7], n[8], n[9], n[10], n[11]);
    return {point(0) + carrier * SymbolicVec3(n[0], n[1], n[2]), turned.column(0), turned.column(1),
            turned.column(2)};
  }
  const std::vector<Scalar> n =
      builder.data_array(placement, kPatchNumbers, "", "placement on the patch: weights, height, rotation");
  const symbolic::Mat3 axes = patch_axes(point(0), point(1), point(2));
  const symbolic::Mat3 local(n[4], n[5], n[6], n[7], n[8], n[9], n[10], n[11], n[12]);
  const symbolic::Mat3 turned = axes * local;
  return {n[0] * point(0) + n[1] * point(1) + n[2] * point(2) + n[3] * axes.column(2), turned.column(0),
          turned.column(1), turned.column(2)};
}

}  // namespace

symbolic::Mat3 patch_axes(const SymbolicVec3& p0, const SymbolicVec3& p1, const SymbolicVec3& p2) {
  const SymbolicVec3 x = symbolic::normalized(p1 - p0);
  const SymbolicVec3 z = symbolic::normalized(symbolic::cross(p1 - p0, p2 - p0));
  return symbolic::Mat3::from_columns(x, symbolic::cross(z, x), z);
}

Scalar constraint_force(const ConstraintRow& row, bool one_sided) {
  const Scalar force = row.multiplier + row.penalty * row.residual;
  return one_sided ? max(force, 0.0) : force;
}

Scalar constraint_energy(const ConstraintRow& row, bool one_sided) {
  const Scalar held = row.residual * (row.multiplier + 0.5 * row.penalty * row.residual);
  if (!one_sided) return held;
  // Where nothing pushes, the energy is constant. Released rows have zero multiplier and penalty.
  const Scalar apart = -0.5 * square(row.multiplier) / max(row.penalty, 1e-300);
  return select(row.multiplier + row.penalty * row.residual > 0.0, held, apart);
}

JointBuilder::JointBuilder(PotentialBuilder& builder, FrameKind kind_a, FrameKind kind_b)
    : builder_(builder) {
  const int first_b = frame_point_count(kind_a);
  a = frame_of(builder, kind_a, 0, "placement_a", &PotentialBuilder::x);
  b = frame_of(builder, kind_b, first_b, "placement_b", &PotentialBuilder::x);
  a_prev = frame_of(builder, kind_a, 0, "placement_a", &PotentialBuilder::x_prev);
  b_prev = frame_of(builder, kind_b, first_b, "placement_b", &PotentialBuilder::x_prev);
  a_initial = frame_of(builder, kind_a, 0, "placement_a", &PotentialBuilder::x_initial);
  b_initial = frame_of(builder, kind_b, first_b, "placement_b", &PotentialBuilder::x_initial);
}

void JointBuilder::hold(const Scalar& residual, ResidualUnit unit) { hold(std::span(&residual, 1), unit); }

void JointBuilder::hold(const SymbolicVec3& residual, ResidualUnit unit) {
  hold(std::span<const Scalar>(residual.v), unit);
}

void JointBuilder::hold(std::span<const Scalar> residuals, ResidualUnit unit) {
  residuals_.insert(residuals_.end(), residuals.begin(), residuals.end());
  units_.insert(units_.end(), residuals.size(), unit);
  one_sided_.insert(one_sided_.end(), residuals.size(), 0);
  hold_sizes_.push_back(static_cast<int>(residuals.size()));
}

void JointBuilder::limit(const Scalar& residual, ResidualUnit unit) {
  hold(residual, unit);
  one_sided_.back() = 1;
}

void JointBuilder::coordinate(const std::string& name, const Scalar& value, const std::string& unit) {
  coordinates_.push_back({name, unit, value});
}

Scalar JointBuilder::parameter(const std::string& name, const std::string& unit, const std::string& doc) {
  return builder_.data(name, unit, doc);
}

SymbolicVec3 JointBuilder::parameter3(const std::string& name, const std::string& unit,
                                      const std::string& doc) {
  return builder_.data3(name, unit, doc);
}

JointDefinition define_joint(std::string name, std::string doc, std::function<void(JointBuilder&)> formula) {
  return {std::move(name), std::move(doc), std::move(formula)};
}

JointDefinition define_joint(std::string name, std::string doc, Formula formula, JointOutputs outputs) {
  STARK_CHECK(formula.point_count() == 8);
  return define_joint(std::move(name), std::move(doc),
                      [formula = std::move(formula), outputs = std::move(outputs)](JointBuilder& j) {
                        const auto points = [](const FrameExpressions& a, const FrameExpressions& b) {
                          return std::vector<SymbolicVec3>{a.origin, a.x, a.y, a.z, b.origin, b.x, b.y, b.z};
                        };
                        const std::vector<Scalar> values =
                            formula.repeat(j.inputs(), {.x = points(j.a, j.b),
                                                        .x_prev = points(j.a_prev, j.b_prev),
                                                        .x_initial = points(j.a_initial, j.b_initial)});
                        size_t next = 0;
                        for (const JointOutputs::Hold& hold : outputs.holds) {
                          j.hold(std::span(values).subspan(next, hold.count), hold.unit);
                          next += hold.count;
                        }
                        for (const JointOutputs::Coordinate& coordinate : outputs.coordinates)
                          j.coordinate(coordinate.name, values[next++], coordinate.unit);
                      });
}

namespace {

/// Parameters of a joint: each joint has its own values.
std::set<std::string> parameter_names(const JointDefinition& definition) {
  std::set<std::string> names;
  for (const ParameterDeclaration& parameter : joint_parameters(definition)) names.insert(parameter.name);
  return names;
}

}  // namespace

Joint::Joint(const JointDefinition& definition, FrameKind kind_a, FrameKind kind_b, symbolic::Backend backend)
    : name_(definition.name), kind_a_(kind_a), kind_b_(kind_b) {
  const int point_count = frame_point_count(kind_a) + frame_point_count(kind_b);
  const std::set<std::string> parameters = parameter_names(definition);
  const auto traced = std::make_shared<PotentialBuilder>(point_count, parameters);
  JointBuilder builder(*traced, kind_a, kind_b);
  definition.formula(builder);
  units_ = builder.units();
  hold_sizes_ = builder.hold_sizes();
  one_sided_ = builder.one_sided();
  std::vector<Scalar> outputs = builder.residuals();
  for (const JointBuilder::Coordinate& coordinate : builder.coordinates()) {
    coordinates_.push_back({coordinate.name, coordinate.unit});
    outputs.push_back(coordinate.value);
  }

  const ReducedFormula formula(traced, outputs);
  points_ = formula.points();
  const auto target = std::make_shared<PotentialBuilder>(static_cast<int>(points_.size()), parameters);
  const std::vector<Scalar> values = formula.repeat(*target);
  const int count = static_cast<int>(units_.size());
  Scalar energy = 0.0;
  if (count > 0) {
    const auto lambda = target->data_array("multiplier", count, "N, N m", "force that holds the residual");
    const auto rho = target->data_array("penalty", count, "N/m, N m", "stiffness of the residual");
    for (int k = 0; k < count; ++k)
      energy += constraint_energy({values[k], lambda[k], rho[k]}, one_sided_[k]);
  }
  potential_ = std::make_shared<Potential>(name_, *target, energy, backend);
  values_ = symbolic::compile_function(values, backend);
}

std::vector<ParameterDeclaration> joint_parameters(const JointDefinition& definition) {
  const PotentialDefinition residuals =
      define_potential(definition.name, 8, definition.doc, [&](PotentialBuilder& traced) {
        JointBuilder builder(traced, FrameKind::Axes, FrameKind::Axes);
        definition.formula(builder);
        return Scalar(0.0);
      });
  std::vector<ParameterDeclaration> parameters = parameters_of(residuals);
  for (ParameterDeclaration& parameter : parameters) parameter.is_data = false;
  return parameters;
}

std::vector<JointOutputs::Coordinate> joint_coordinates(const JointDefinition& definition) {
  PotentialBuilder traced(2 * frame_point_count(FrameKind::Axes));
  JointBuilder builder(traced, FrameKind::Axes, FrameKind::Axes);
  definition.formula(builder);
  std::vector<JointOutputs::Coordinate> coordinates;
  for (const JointBuilder::Coordinate& coordinate : builder.coordinates())
    coordinates.push_back({coordinate.name, coordinate.unit});
  return coordinates;
}

}  // namespace stark
