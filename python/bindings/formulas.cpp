// Bindings of what user energies are made of: the builder in which Python writes a formula, the finished
// formula, its evaluation for checks, and energies of scenes and simulations. The front end is
// stark/formulas.
#include <stark/mechanics/constitutive_law.h>
#include <stark/mechanics/formula_sample.h>
#include <stark/mechanics/law_density.h>
#include <stark/sim/scene/registry.h>
#include <stark/symbolic/substitute.h>

#include "symbolic.h"

namespace stark::bindings {

namespace {

/// Inputs and graph of a formula that is being written.
struct Builder {
  explicit Builder(int points) : inputs(std::make_shared<PotentialBuilder>(points)) {}
  explicit Builder(std::shared_ptr<PotentialBuilder> of) : inputs(std::move(of)) {}
  const std::shared_ptr<symbolic::Graph>& graph() const { return inputs->graph(); }

  std::shared_ptr<PotentialBuilder> inputs;
};

TracedScalar traced(const Builder& builder, const symbolic::Scalar& value) {
  return {builder.graph(), value};
}

nb::list traced(const Builder& builder, std::span<const symbolic::Scalar> values) {
  return list_of(values, [&](const symbolic::Scalar& value) { return traced(builder, value); });
}
nb::list traced(const Builder& builder, const symbolic::Vec3& values) { return traced(builder, values.v); }

/// A method of the builder.
template <typename Result, typename... Args>
auto recorded(Result (PotentialBuilder::*method)(Args...)) {
  return [=](const Builder& builder, Args... args) {
    return traced(builder, ((*builder.inputs).*method)(args...));
  };
}

/// `is_energy`: of elements in a scene, which have sums over all of them.
Formula finish(const Builder& builder, nb::handle outputs, bool is_energy) {
  std::vector<symbolic::Scalar> values;
  for (const TracedScalar& output : require_traced_list(outputs, "outputs of the formula")) {
    if (output.graph && output.graph != builder.graph())
      throw TraceError("the formula returns values of another formula; use its own arguments only");
    values.push_back(output.value);
    if (!is_energy && !symbolic::totals_in(output.value).empty())
      throw TraceError(
          "stark.total(...) has no meaning here: it is the sum over all elements of an energy; use it in a "
          "function of @stark.energy");
  }
  return Formula(builder.inputs, std::move(values));
}

auto parameter(const Builder& builder, const std::string& name, int width, const std::string& unit,
               const std::string& doc, const std::tuple<double, double, bool, bool>& range) {
  const auto& [low, high, low_open, high_open] = range;
  const FieldRule rule{low, high, low_open, high_open, false};
  return traced(builder, builder.inputs->parameter_array(name, width, unit, doc, rule));
}

/// A number with a place among the operations: sums order their terms by it.
TracedScalar constant(const Builder& builder, double value) {
  symbolic::Graph* graph = builder.graph().get();
  return traced(builder, symbolic::Scalar(graph, graph->constant(value)));
}

void set_name(const Builder& builder, const TracedScalar& value, const std::string& name) {
  builder.graph()->set_name(value.value, name);
}

/// A built-in potential as a formula.
Formula registered_formula(const std::string& name) { return formula_of(find_potential(name)); }

template <typename Law, Law (*from)(std::string, std::string, Formula)>
Law law_of(const std::string& name, const std::string& doc, const Formula& formula, bool isotropic) {
  Law law = from(name, doc, formula);
  law.isotropic = isotropic;
  return law;
}

/// (psi, columns of the strain, rows of parameters with their inputs).
template <typename Law>
nb::tuple law_density(const Law& law) {
  const auto [inputs, psi] = density_of(law);
  const Builder builder(inputs);
  nb::list parameters, columns;
  for (const UniformField& field : inputs->uniform_fields()) {
    const FieldRule& rule = field.rule;
    nb::dict row = dict_of_readings(field);
    row["range"] = nb::make_tuple(rule.low, rule.high, rule.low_open, rule.high_open);
    row["inputs"] = traced(builder, inputs->parameter_like(field));
    parameters.append(row);
  }
  for (int j = 0; j < inputs->point_count(); ++j) columns.append(traced(builder, inputs->x(j)));
  return nb::make_tuple(traced(builder, psi), columns, parameters);
}

/// The formula on elements that are given by name.
FormulaSample make_sample(const Formula& formula, const nb::dict& given, symbolic::Backend backend) {
  const auto read_points = [&](const char* name) {
    return array_of<Vec3>(given[name], name, "an (n, 3) array of positions");
  };
  SamplePoints points{read_points("x"), read_points("X"), read_points("x_prev"), read_points("x_initial")};
  points.time_step = nb::cast<double>(given["time_step"]);
  points.time = nb::cast<double>(given["time"]);
  const nb::dict values = nb::cast<nb::dict>(given["values"]);
  return {formula, backend, std::move(points), [&](const ParameterDeclaration& field) {
            return array_of<double>(values[field.name.c_str()], field.name, "a flat array of numbers");
          }};
}

symbolic::KernelStatistics statistics(const Formula& formula, symbolic::Backend backend) {
  return Potential(define_potential("formula", "", formula), backend).kernel().statistics();
}

}  // namespace

void bind_formulas(nb::module_& m) {
  nb::class_<Builder> builder(m, "FormulaBuilder", "Inputs of a formula while it is being written.");
  builder.def(nb::init<int>(), "points"_a);
  def(builder, "x", recorded(&PotentialBuilder::x), {"point"}, "Unknown position [m].");
  def(builder, "X", recorded(&PotentialBuilder::X), {"point"}, "Rest position [m].");
  def(builder, "x_prev", recorded(&PotentialBuilder::x_prev), {"point"}, "At the start of the step [m].");
  def(builder, "x_initial", recorded(&PotentialBuilder::x_initial), {"point"}, "At time 0 [m].");
  def(builder, "time_step", recorded(&PotentialBuilder::time_step), "[s]");
  def(builder, "time", recorded(&PotentialBuilder::time), "At the end of the step [s].");
  def(builder, "data", recorded(&PotentialBuilder::data_array), {"name", "width", "unit", "doc"},
      "Input given for each element.");
  def(builder, "internal", recorded(&PotentialBuilder::internal), {"name", "initial", "unit", "doc"},
      "Internal variable of each element, with its value at time 0; later outputs update it.");
  def(builder, "parameter", parameter, {"name", "width", "unit", "doc", "range"},
      "Input shared by all elements or given for each; range is (low, high, low_open, high_open).");
  def<constant>(builder, {"value"});
  builder.def("set_name", set_name, "value"_a, "name"_a, "Names an input for printing.");
  def(builder, "finish", finish, {"outputs", {"is_energy", false}}, "The formula with these outputs.");
  using Sample = FormulaSample;
  nb::class_<Sample> sample(m, "FormulaSample", "A compiled formula on given elements.");
  def<&Sample::set_positions>(sample, {"x: an (n, 3) array of positions"});
  def<&Sample::evaluate, &Sample::run>(sample, {"order"});
  nb::class_<Formula> formula(m, "Formula",
                              "A formula of points and parameters, ready to be used in energies.");
  property<&Formula::point_count>(formula);
  property(formula, "fields", nb::overload_cast<const Formula&>(&parameters_of),
           "Inputs to be given: name, unit, doc, width, is_data.");
  def(formula, "sample", make_sample, {"inputs", {"backend", "automatic"}},
      "The formula on elements that are given as arrays.");
  def<statistics>(formula, {{"backend", "automatic"}});
  // Of the columns of the deformation gradient, 3 points of solids and 2 of shells; of rods of the points
  // (0, 0, stretch) and (curvature 1, curvature 2, twist).
  def(m, "solid_law", law_of<SolidLaw, solid_law_from>, {"name", "doc", "formula", "isotropic"});
  def(m, "shell_law", law_of<ShellLaw, shell_law_from>, {"name", "doc", "formula", "isotropic"});
  def(m, "rod_law", rod_law_from, {"name", "doc", "formula"});
  def<law_density<SolidLaw>, law_density<ShellLaw>, law_density<RodLaw>>(m, {"law"});
  def<registered_formula>(m, {"name"});
}

}  // namespace stark::bindings
