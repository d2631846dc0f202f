// Bindings of what user energies are made of: the builder in which Python writes a formula, the finished
// formula, its evaluation for checks, and energies of scenes and simulations. The front end is
// stark/formulas.
#include <nanobind/nanobind.h>
#include <nanobind/stl/string.h>
#include <nanobind/stl/tuple.h>
#include <nanobind/stl/vector.h>

#include <stark/mechanics/constitutive_law.h>
#include <stark/mechanics/formula_sample.h>
#include <stark/mechanics/law_density.h>
#include <stark/sim/registry.h>

#include "domains.h"
#include "given.h"
#include "symbolic.h"

namespace stark::bindings {

using namespace nb::literals;
using symbolic::Order;

namespace {

/// Inputs and graph of a formula that is being written.
using Builder = std::shared_ptr<PotentialBuilder>;

TracedScalar traced(const Builder& builder, const symbolic::Scalar& value) {
  return {builder->graph(), value};
}

nb::list traced_list(const Builder& builder, std::span<const symbolic::Scalar> values) {
  nb::list list;
  for (const symbolic::Scalar& value : values) list.append(traced(builder, value));
  return list;
}

Formula finish(const Builder& builder, nb::handle outputs) {
  std::vector<symbolic::Scalar> values;
  for (const TracedScalar& output : require_traced_list(outputs, "outputs of the formula")) {
    if (output.graph && output.graph != builder->graph())
      throw TraceError("the formula returns values of another formula; use its own arguments only");
    values.push_back(output.value);
  }
  return Formula(builder, std::move(values));
}

Formula registered_formula(const std::string& name) {
  for (const PotentialDefinition& definition : registered_potentials())
    if (definition.name == name) return formula_of(definition);
  throw InvalidArgument("potential '" + name + "' is not registered; stark._core.potentials() lists all");
}

template <typename Law, Law (*from)(std::string, std::string, Formula)>
Law law_of(const std::string& name, const std::string& doc, const Formula& formula, bool isotropic) {
  Law law = from(name, doc, formula);
  law.isotropic = isotropic;
  return law;
}

/// (psi, columns of the strain, rows of parameters with their inputs).
template <typename Law>
nb::tuple law_density(const Law& law) {
  const auto [builder, psi] = density_of(law);
  nb::list parameters, columns;
  for (const UniformField& field : builder->uniform_fields()) {
    const FieldRule& rule = field.rule;
    parameters.append(dict_of("name", field.name, "unit", field.unit, "doc", field.doc, "width", field.width,
                              "range", nb::make_tuple(rule.low, rule.high, rule.low_open, rule.high_open),
                              "inputs", traced_list(builder, builder->parameter_like(field))));
  }
  for (int j = 0; j < builder->point_count(); ++j) columns.append(traced_list(builder, builder->x(j).v));
  return nb::make_tuple(traced(builder, psi), columns, parameters);
}

/// The formula on elements that are given by name.
FormulaSample make_sample(const Formula& formula, const nb::dict& given, symbolic::Backend backend) {
  SamplePoints points{.x = points_of(given["x"], "x", "an (n, 3) array of positions")};
  const size_t count = points.x.size();
  points.X = points_of(given["X"], "X", count);
  points.x_prev = points_of(given["x_prev"], "x_prev", count);
  points.x_initial = points_of(given["x_initial"], "x_initial", count);
  points.time_step = nb::cast<double>(given["time_step"]);
  points.time = nb::cast<double>(given["time"]);
  const nb::dict values = nb::cast<nb::dict>(given["values"]);
  return {formula, backend, std::move(points), [&](const ParameterDeclaration& field) {
            return numbers_of<double>(values[field.name.c_str()], field.name, "a flat array of numbers");
          }};
}

symbolic::Backend to_backend(const std::string& name) {
  const auto& names = EnumNames<symbolic::Backend>::kNames;
  for (size_t k = 0; k < names.size(); ++k)
    if (names[k] == name) return static_cast<symbolic::Backend>(k);
  throw InvalidArgument("backend = '" + name + "': must be automatic, interpreter, avx2, avx512 or neon");
}

nb::dict statistics(const Formula& formula, const std::string& backend) {
  const Potential potential(define_potential("formula", "", formula), to_backend(backend));
  const symbolic::KernelStatistics& s = potential.kernel().statistics();
  const auto triple = [](const auto& v) { return nb::make_tuple(v[0], v[1], v[2]); };
  return dict_of("operations", triple(s.operations), "instructions", triple(s.instructions), "code_bytes",
                 triple(s.code_bytes), "build_seconds", triple(s.build_seconds), "algorithm", s.algorithm,
                 "backend", s.backend, "unknowns", potential.kernel().unknown_count());
}

}  // namespace
}  // namespace stark::bindings

void bind_formulas(nanobind::module_& m) {
  using namespace stark;
  using namespace stark::bindings;
  nb::class_<Builder>(m, "FormulaBuilder", "Inputs of a formula of n points while it is being written.")
      .def("__init__",
           [](Builder* self, int points) { new (self) Builder(std::make_shared<PotentialBuilder>(points)); })
      .def(
          "x", [](const Builder& b, int p) { return traced_list(b, b->x(p).v); }, "Unknown position [m].")
      .def(
          "X", [](const Builder& b, int p) { return traced_list(b, b->X(p).v); }, "Rest position [m].")
      .def(
          "x_prev", [](const Builder& b, int p) { return traced_list(b, b->x_prev(p).v); },
          "Position at the start of the step [m].")
      .def(
          "x_initial", [](const Builder& b, int p) { return traced_list(b, b->x_initial(p).v); },
          "Position in the world at time 0 [m].")
      .def(
          "time_step", [](const Builder& b) { return traced(b, b->time_step()); }, "[s]")
      .def(
          "time", [](const Builder& b) { return traced(b, b->time()); }, "At the end of the step [s].")
      .def(
          "parameter",
          [](const Builder& b, const std::string& name, int width, const std::string& unit,
             const std::string& doc, const std::tuple<double, double, bool, bool>& range) {
            const auto& [low, high, low_open, high_open] = range;
            const FieldRule rule{low, high, low_open, high_open, false};
            return traced_list(b, b->parameter_array(name, width, unit, doc, rule));
          },
          "name"_a, "width"_a, "unit"_a, "doc"_a, "range"_a,
          "Input shared by all elements or given for each; range is (low, high, low_open, high_open).")
      .def(
          "data",
          [](const Builder& b, const std::string& name, int width, const std::string& unit,
             const std::string& doc) { return traced_list(b, b->data_array(name, width, unit, doc)); },
          "name"_a, "width"_a, "unit"_a, "doc"_a, "Input given for each element.")
      .def(
          "internal",
          [](const Builder& b, const std::string& name, const std::vector<double>& initial,
             const std::string& unit,
             const std::string& doc) { return traced_list(b, b->internal(name, initial, unit, doc)); },
          "name"_a, "initial"_a, "unit"_a, "doc"_a,
          "Internal variable of each element, with its value at time 0; later outputs of the formula update "
          "it.")
      .def(
          "constant",
          [](const Builder& b, double value) {
            symbolic::Graph* graph = b->graph().get();
            return traced(b, symbolic::Scalar(graph, graph->constant(value)));
          },
          "value"_a, "A number with a place among the operations: sums order their terms by it.")
      .def(
          "set_name",
          [](const Builder& b, const TracedScalar& value, const std::string& name) {
            b->graph()->set_name(value.value, name);
          },
          "value"_a, "name"_a, "Names an input for printing.")
      .def("finish", &finish, "outputs"_a, "The formula with these scalars as outputs.");
  using Sample = FormulaSample;
  nb::class_<Sample>(m, "FormulaSample", "A compiled formula on given elements, outside of any simulation.")
      .def(
          "set_positions",
          [](Sample& s, nb::handle x) { s.set_positions(points_of(x, "x", s.point_count())); }, "x"_a,
          "New positions of all points.")
      .def(
          "evaluate",
          [](const Sample& s, int order) { return to_numpy(s.evaluate(static_cast<Order>(order))); },
          "order"_a,
          "Energy, gradient, upper triangle of the Hessian of each element, in a row one after another.")
      .def(
          "run", [](const Sample& s, int order) { s.run(static_cast<Order>(order)); }, "order"_a,
          "Evaluates and forgets the results, for timings.");
  nb::class_<Formula>(m, "Formula", "A formula of points and parameters, ready to be used in energies.")
      .def_prop_ro("point_count", &Formula::point_count)
      .def_prop_ro(
          "fields", [](const Formula& f) { return describe(parameters_of(f)); },
          "Inputs to be given: name, unit, doc, width, is_data.")
      .def(
          "sample",
          [](const Formula& f, const nb::dict& inputs, const std::string& backend) {
            return make_sample(f, inputs, to_backend(backend));
          },
          "inputs"_a, "backend"_a = "automatic", "The formula on elements that are given as arrays.")
      .def("statistics", &statistics, "backend"_a = "automatic");
  m.def("solid_law", &law_of<SolidLaw, solid_law_from>, "name"_a, "doc"_a, "formula"_a, "isotropic"_a,
        "Law of solids from a formula of 3 points, the columns of the deformation gradient.");
  m.def("rod_law", &rod_law_from, "name"_a, "doc"_a, "formula"_a,
        "Law of a rod from a formula of the points (0, 0, stretch) and (curvature 1, curvature 2, twist).");
  m.def("shell_law", &law_of<ShellLaw, shell_law_from>, "name"_a, "doc"_a, "formula"_a, "isotropic"_a,
        "Law of shells from a formula of 2 points, the columns of the deformation gradient.");
  m.def(
      "element_formula", [](const SolidLaw& law) { return formula_of(tet4(law)); }, "law"_a,
      "A law on linear tetrahedra.");
  m.def(
      "element_formula", [](const ShellLaw& law) { return formula_of(triangle3(law)); }, "law"_a,
      "A law on triangles.");
  m.def(
      "element_formula", [](const RodLaw& law) { return formula_of(rod_segment(law)); }, "law"_a,
      "A law on segments of rods.");
  m.def("law_density", law_density<SolidLaw>, "law"_a,
        "(psi, columns of F, parameters) of a law as expressions of one graph.");
  m.def("law_density", law_density<ShellLaw>, "law"_a,
        "(psi, columns of F, parameters) of a law as expressions of one graph.");
  m.def("law_density", law_density<RodLaw>, "law"_a,
        "(psi, [(0, 0, stretch), (curvature 1, curvature 2, twist)], parameters).");
  m.def("registered_formula", &registered_formula, "name"_a, "A built-in potential as a formula.");
}
