// A potential: a named energy of n points with parameters, written once as a formula and compiled by the
// symbolic engine. Built-in and user energies use exactly this mechanism; no derivative is written by hand.
//
//   PotentialDefinition gravity() {
//     return define_potential("gravity", 1, "...", [](PotentialBuilder& b) {
//       return -b.data("mass", "kg", "...") * dot(b.parameter3("acceleration", ...), b.x(0));
//     });
//   }
#pragma once

#include <functional>
#include <map>
#include <memory>
#include <random>
#include <set>
#include <string>
#include <vector>

#include <stark/base/math.h>
#include <stark/base/settings.h>
#include <stark/symbolic/evaluate.h>
#include <stark/symbolic/kernel.h>
#include <stark/symbolic/tensor.h>

namespace stark {

/// A per-element input of a potential; stored once per element, `width` numbers each.
struct ElementField {
  enum class Source : uint8_t {
    Data,      ///< set by the model (PotentialBatch::set)
    Rest,      ///< rest position of point `point` [m]
    Previous,  ///< position of point `point` at the start of the time step [m], refreshed every step
    Initial,   ///< position of point `point` in the world at time 0 [m]
    Beyond,    ///< of point `point` [m], see PotentialBuilder::reference; Previous unless the step has a
               ///< history
    Internal,  ///< internal variable at the start of the step, see PotentialBuilder::internal
  };
  std::string name;
  std::string unit;
  std::string doc;
  Source source = Source::Data;
  int point = 0;
  int width = 1;
  int offset = 0;  ///< first number within the element's inputs
  FieldRule rule = any_number();
  bool is_direction = false;      ///< three numbers that are not all zero, of any length
  std::vector<double> initial{};  ///< of internal variables: value at time 0
};

/// An input shared by all elements of a batch. "time_step" and "time" are set by the integrator, the others
/// by the model.
struct UniformField {
  std::string name;
  std::string unit;
  std::string doc;
  int width = 1;
  int offset = 0;
  FieldRule rule = any_number();
  bool is_direction = false;  ///< three numbers that are not all zero, of any length
};

class PotentialBuilder;
class TotalEnergy;

/// Random feasible inputs of a potential, for the automatic tests of every registered one. Empty members are
/// filled with defaults: a well-shaped simplex of about 1 m, strained by up to 20 %, parameters in
/// [0.5, 1.5].
struct PotentialSample {
  std::vector<Vec3> X, x_prev, x;
  std::map<std::string, std::vector<double>> values;  ///< element data and parameters by name
};

struct PotentialDefinition {
  std::string name;
  int point_count = 0;
  std::string doc;
  std::function<symbolic::Scalar(PotentialBuilder&)> energy;
  bool translation_invariant = true;  ///< declared; checked by the registry sweep
  bool rotation_invariant = true;     ///< declared; checked by the registry sweep
  bool zero_at_rest = false;  ///< declared: no energy and no force at x = x_prev = X; checked likewise
  /// Declared: where the energy is exactly zero, so are gradient and Hessian, as of a penalty that does not
  /// act. Elements without energy are then left out of assembly; checked likewise.
  bool one_sided = false;
  std::function<PotentialSample(std::mt19937_64&)> sample;  ///< empty: the defaults of PotentialSample
};

/// Vocabulary in which an energy is written. Every method may be called again with the same name.
class PotentialBuilder {
 public:
  /// `per_element`: names of parameters that differ from element to element in the batch at hand.
  explicit PotentialBuilder(int point_count, std::set<std::string> per_element = {});

  /// One of x, X, x_prev, ...: which position of a point is meant.
  using Position = symbolic::Vec3 (PotentialBuilder::*)(int);
  symbolic::Vec3 x(int point);          ///< unknown position [m]
  symbolic::Vec3 X(int point);          ///< rest position, in the frame of its body [m]
  symbolic::Vec3 x_prev(int point);     ///< position at the start of the step [m]
  symbolic::Vec3 x_initial(int point);  ///< position in the world at time 0 [m]
  symbolic::Vec3 x_beyond(int point);   ///< x_prev + d, see reference() [m]
  symbolic::Vec3 x_behind(int point);   ///< x_prev - d, see reference() [m]
  symbolic::Vec3 velocity(int point);   ///< (x - x_prev) / h [m/s]

  /// What the change of a measure g within the step is to be taken from, so that (g(x) - reference) / h is
  /// its rate to the order of the integrator: with a history, g at the extrapolated x_prev is not the
  /// extrapolated g. [theory eq. 26b] `measure` maps a Position, x_prev, x_beyond or x_behind, to a value.
  template <typename Measure>
  auto reference(const Measure& measure) {
    const auto at = measure(&PotentialBuilder::x_prev);
    return at * 2.0 - (measure(&PotentialBuilder::x_beyond) + measure(&PotentialBuilder::x_behind)) * 0.5;
  }
  symbolic::Scalar time_step();  ///< h [s]
  symbolic::Scalar time();       ///< at the end of the step [s]

  /// Input that every element has a value of. `parameter` is shared by all elements instead, unless the batch
  /// has a value for each: which of the two does not concern the formula. `rule` is the range of its values;
  /// the first declaration of a name counts.
  symbolic::Scalar data(const std::string& name, const std::string& unit, const std::string& doc);
  symbolic::Vec3 data3(const std::string& name, const std::string& unit, const std::string& doc);
  std::vector<symbolic::Scalar> data_array(const std::string& name, int width, const std::string& unit,
                                           const std::string& doc);
  symbolic::Scalar parameter(const std::string& name, const std::string& unit, const std::string& doc,
                             const FieldRule& rule = any_number());
  symbolic::Vec3 parameter3(const std::string& name, const std::string& unit, const std::string& doc);
  /// A parameter of three numbers that are not all zero, as the unit vector in that direction.
  symbolic::Vec3 direction(const std::string& name, const std::string& doc);
  /// A parameter of any width, in row-major order for matrices.
  std::vector<symbolic::Scalar> parameter_array(const std::string& name, int width, const std::string& unit,
                                                const std::string& doc, const FieldRule& rule = any_number());
  /// The parameter that `declaration` describes, its offset aside.
  std::vector<symbolic::Scalar> parameter_like(const UniformField& declaration);

  /// Internal variable: what every element remembers from step to step, such as a plastic strain. Its value
  /// at the start of the step; row-major order for matrices. `update` says what it becomes when a step is
  /// accepted; without, it keeps its value.
  std::vector<symbolic::Scalar> internal(const std::string& name, const std::vector<double>& initial,
                                         const std::string& unit, const std::string& doc);
  /// Value of an internal variable at the end of an accepted step, as a formula of everything that an energy
  /// may use. Throws InvalidArgument for unknown names, other numbers of values and second updates.
  void update(const std::string& name, const std::vector<symbolic::Scalar>& values);
  /// By internal variable, in the order of element_fields(): its updated values.
  std::vector<symbolic::Scalar> updates() const;

  const std::shared_ptr<symbolic::Graph>& graph() const { return graph_; }
  int point_count() const { return static_cast<int>(x_.size()); }
  const std::vector<ElementField>& element_fields() const { return element_fields_; }
  const std::vector<UniformField>& uniform_fields() const { return uniform_fields_; }

 private:
  symbolic::Vec3 position(const char* name, const char* doc, ElementField::Source source, int point);
  const std::vector<symbolic::Scalar>& element_field(const ElementField& field);
  const std::vector<symbolic::Scalar>& uniform_field(const UniformField& field);

  std::shared_ptr<symbolic::Graph> graph_;
  std::set<std::string> per_element_;
  std::vector<symbolic::Vec3> x_;
  std::vector<ElementField> element_fields_;
  std::vector<UniformField> uniform_fields_;
  std::vector<std::vector<symbolic::Scalar>> element_values_, uniform_values_;
  std::map<std::string, std::vector<symbolic::Scalar>> updates_;
};

/// A compiled potential. Immutable; shared by all batches that use it.
class Potential {
 public:
  /// `per_element`: names of parameters that get a value for each element (ElementField::Source::Data).
  Potential(const PotentialDefinition& definition, symbolic::Backend backend,
            const std::set<std::string>& per_element = {});
  /// Of an energy that has been written with `builder` already.
  Potential(std::string name, const PotentialBuilder& builder, const symbolic::Scalar& energy,
            symbolic::Backend backend, bool translation_invariant = false);

  const std::string& name() const { return name_; }
  int point_count() const { return point_count_; }
  bool is_translation_invariant() const { return translation_invariant_; }
  bool is_one_sided() const { return one_sided_; }
  int element_width() const { return element_width_; }
  int uniform_width() const { return uniform_width_; }
  const std::vector<ElementField>& element_fields() const { return element_fields_; }
  const std::vector<UniformField>& uniform_fields() const { return uniform_fields_; }
  /// Energy of an element; of an energy of totals the plane that touches it (mechanics/total_energy.h).
  const symbolic::Kernel& kernel() const { return kernel_; }
  /// nullptr where the energy has no totals, but is a sum over elements.
  const TotalEnergy* totals() const { return totals_.get(); }
  /// Numbers of the internal variables of an element, in the order of element_fields().
  int internal_width() const { return internal_width_; }
  /// Their values after an accepted step; empty without internal variables.
  const symbolic::Function& update() const { return update_; }
  /// Whether these depend on the time step: what they remember flows at a rate.
  bool flows_at_a_rate() const { return flows_at_a_rate_; }

 private:
  std::string name_;
  int point_count_ = 0;
  bool translation_invariant_ = true;
  bool one_sided_ = false;
  bool flows_at_a_rate_ = false;
  int element_width_ = 0, uniform_width_ = 0, internal_width_ = 0;
  std::vector<ElementField> element_fields_;
  std::vector<UniformField> uniform_fields_;
  std::shared_ptr<const TotalEnergy> totals_;
  symbolic::Kernel kernel_;
  symbolic::Function update_;
};

/// Definition of an energy of `point_count` points.
PotentialDefinition define_potential(std::string name, int point_count, std::string doc,
                                     std::function<symbolic::Scalar(PotentialBuilder&)> energy);

/// Sum of several energies on the same points as one potential: shared subexpressions are evaluated once.
PotentialDefinition compose(std::string name, const std::vector<PotentialDefinition>& terms);

}  // namespace stark
