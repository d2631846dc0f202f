// Bindings of what user energies are made of: the builder in which Python writes a formula, the finished
// formula, its evaluation for checks, and energies of scenes and simulations. The front end is
// stark/formulas.
#include <stark/mechanics/constitutive_law.h>
#include <stark/mechanics/formula_sample.h>
#include <stark/mechanics/law_density.h>
#include <stark/sim/registry.h>
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
    parameters.append(dict_of("name", field.name, "unit", field.unit, "doc", field.doc, "width", field.width,
                              "range", nb::make_tuple(rule.low, rule.high, rule.low_open, rule.high_open),
                              "inputs", traced(builder, inputs->parameter_like(field))));
  }
  for (int j = 0; j < inputs->point_count(); ++j) columns.append(traced(builder, inputs->x(j)));
  return nb::make_tuple(traced(builder, psi), columns, parameters);
}

/// The formula on elements that are given by name.
FormulaSample make_sample(const Formula& formula, const nb::dict& given, const std::string& backend) {
  const auto read_points = [&](const char* name) {
    return array_of<Vec3>(given[name], name, "an (n, 3) array of positions");
  };
  SamplePoints points{read_points("x"), read_points("X"), read_points("x_prev"), read_points("x_initial")};
  points.time_step = nb::cast<double>(given["time_step"]);
  points.time = nb::cast<double>(given["time"]);
  const nb::dict values = nb::cast<nb::dict>(given["values"]);
  return {formula, backend_of(backend), std::move(points), [&](const ParameterDeclaration& field) {
            return array_of<double>(values[field.name.c_str()], field.name, "a flat array of numbers");
          }};
}

nb::dict statistics(const Formula& formula, const std::string& backend) {
  const Potential potential(define_potential("formula", "", formula), backend_of(backend));
  const symbolic::KernelStatistics& s = potential.kernel().statistics();
  const auto triple = [](const auto& v) { return nb::make_tuple(v[0], v[1], v[2]); };
  return dict_of("operations", triple(s.operations), "instructions", triple(s.instructions), "code_bytes",
                 triple(s.code_bytes), "build_seconds", triple(s.build_seconds), "algorithm", s.algorithm,
                 "backend", s.backend, "unknowns", potential.kernel().unknown_count());
}

}  // namespace

void bind_formulas(nb::module_& m) {
  nb::class_<Builder>(m, "FormulaBuilder", "Inputs of a formula of n points while it is being written.")
      .def(nb::init<int>())
      .def("x", recorded(&PotentialBuilder::x), "Unknown position [m].")
      .def("X", recorded(&PotentialBuilder::X), "Rest position [m].")
      .def("x_prev", recorded(&PotentialBuilder::x_prev), "Position at the start of the step [m].")
      .def("x_initial", recorded(&PotentialBuilder::x_initial), "Position in the world at time 0 [m].")
      .def("time_step", recorded(&PotentialBuilder::time_step), "[s]")
      .def("time", recorded(&PotentialBuilder::time), "At the end of the step [s].")
      .def(
          "parameter",
          [](const Builder& b, const std::string& name, int width, const std::string& unit,
             const std::string& doc, const std::tuple<double, double, bool, bool>& range) {
            const auto& [low, high, low_open, high_open] = range;
            const FieldRule rule{low, high, low_open, high_open, false};
            return traced(b, b.inputs->parameter_array(name, width, unit, doc, rule));
          },
          "name"_a, "width"_a, "unit"_a, "doc"_a, "range"_a,
          "Input shared by all elements or given for each; range is (low, high, low_open, high_open).")
      .def("data", recorded(&PotentialBuilder::data_array), "name"_a, "width"_a, "unit"_a, "doc"_a,
           "Input given for each element.")
      .def("internal", recorded(&PotentialBuilder::internal), "name"_a, "initial"_a, "unit"_a, "doc"_a,
           "Internal variable of each element, with its value at time 0; later outputs of the formula update "
           "it.")
      .def(
          "constant",
          [](const Builder& b, double value) {
            symbolic::Graph* graph = b.graph().get();
            return traced(b, symbolic::Scalar(graph, graph->constant(value)));
          },
          "value"_a, "A number with a place among the operations: sums order their terms by it.")
      .def(
          "set_name",
          [](const Builder& b, const TracedScalar& value, const std::string& name) {
            b.graph()->set_name(value.value, name);
          },
          "value"_a, "name"_a, "Names an input for printing.")
      .def("finish", &finish, "outputs"_a, "is_energy"_a = false,
           "The formula with these scalars as outputs.");
  using Sample = FormulaSample;
  nb::class_<Sample>(m, "FormulaSample", "A compiled formula on given elements, outside of any simulation.")
      .def("set_positions", with_arrays<&Sample::set_positions, "x: an (n, 3) array of positions">, "x"_a,
           "New positions of all points.")
      .def("evaluate", with_arrays<&Sample::evaluate>, "order"_a,
           "Energy, gradient, upper triangle of the Hessian of each element, in a row one after another.")
      .def("run", &Sample::run, "order"_a, "Evaluates and forgets the results, for timings.");
  nb::class_<Formula>(m, "Formula", "A formula of points and parameters, ready to be used in energies.")
      .def_prop_ro("point_count", &Formula::point_count)
      .def_prop_ro("fields", nb::overload_cast<const Formula&>(&parameters_of),
                   "Inputs to be given: name, unit, doc, width, is_data.")
      .def("sample", &make_sample, "inputs"_a, "backend"_a = "automatic",
           "The formula on elements that are given as arrays.")
      .def("statistics", &statistics, "backend"_a = "automatic");
  m.def("solid_law", &law_of<SolidLaw, solid_law_from>, "name"_a, "doc"_a, "formula"_a, "isotropic"_a,
        "Law of solids from a formula of 3 points, the columns of the deformation gradient.");
  m.def("rod_law", &rod_law_from, "name"_a, "doc"_a, "formula"_a,
        "Law of a rod from a formula of the points (0, 0, stretch) and (curvature 1, curvature 2, twist).");
  m.def("shell_law", &law_of<ShellLaw, shell_law_from>, "name"_a, "doc"_a, "formula"_a, "isotropic"_a,
        "Law of shells from a formula of 2 points, the columns of the deformation gradient.");
  m.def("law_density", law_density<SolidLaw>, "law"_a,
        "(psi, columns of F, parameters) of a law as expressions of one graph.");
  m.def("law_density", law_density<ShellLaw>, "law"_a,
        "(psi, columns of F, parameters) of a law as expressions of one graph.");
  m.def("law_density", law_density<RodLaw>, "law"_a,
        "(psi, [(0, 0, stretch), (curvature 1, curvature 2, twist)], parameters).");
  m.def("registered_formula", &registered_formula, "name"_a, "A built-in potential as a formula.");
}

}  // namespace stark::bindings
