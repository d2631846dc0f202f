#include <stark/mechanics/total_energy.h>

#include <algorithm>
#include <map>

#include <stark/base/aligned.h>
#include <stark/base/error.h>
#include <stark/base/hash.h>
#include <stark/mechanics/canonical_kernel.h>
#include <stark/symbolic/substitute.h>

namespace stark {

using symbolic::InputKind;
using symbolic::kLanes;
using symbolic::NodeId;
using symbolic::Order;
using symbolic::Scalar;

namespace {

[[noreturn]] void refuse_outside(const std::string& what) {
  throw InvalidArgument(what +
                        " occurs outside of total(...): an energy with totals must depend on its elements by "
                        "them alone; add the rest as an energy of its own, or take the total of it, too");
}

/// The measures and the plane are of the same elements, in a graph with the inputs of the builder's.
Scalar copied(symbolic::Graph& graph, const Scalar& expression) {
  if (!symbolic::totals_in(expression).empty())
    throw InvalidArgument(
        "total(...) within total(...): must be a sum over elements of what one element has; take the inner "
        "sum apart, or multiply with it outside");
  const Scalar one[] = {expression};
  return symbolic::substitute(
             one, [&](InputKind kind, int index) { return Scalar(&graph, graph.input_node(kind, index)); })
      .at(0);
}

/// f with totals for unknowns.
Scalar outer_formula(const PotentialBuilder& builder, const Scalar& energy,
                     const std::vector<Scalar>& measures, symbolic::Graph& graph) {
  const auto input = [&](InputKind kind, int index) -> Scalar {
    if (kind == InputKind::Unknown) refuse_outside("a position of point " + std::to_string(index / 3));
    if (kind == InputKind::Element)
      refuse_outside("'" + field_at(builder.element_fields(), index).name +
                     "', which each element has its own of,");
    return {&graph, graph.input_node(kind, index)};
  };
  return symbolic::substitute(energy, input, [&](NodeId operand) {
    const auto found = std::ranges::find(measures, operand, &Scalar::id);
    return Scalar(&graph, graph.input_node(InputKind::Unknown, static_cast<int>(found - measures.begin())));
  });
}

}  // namespace

TotalEnergy::TotalEnergy(const PotentialBuilder& builder, const Scalar& energy, symbolic::Backend backend) {
  const std::vector<Scalar> measures = symbolic::totals_in(energy);
  const symbolic::InputLabel labels = labels_of(builder);
  const InputCounts counts = input_counts(builder);
  const int m = static_cast<int>(measures.size());
  symbolic::Graph outer, inner;
  const Scalar f = outer_formula(builder, energy, measures, outer);
  outer_ = compile_canonical(f, labels, {m, 0, counts.uniforms}, backend);
  const auto uniform = [&](int k) {
    return Scalar(&inner, inner.input_node(InputKind::Uniform, counts.uniforms + k));
  };
  Scalar plane = uniform(m);
  for (int k = 0; k < m; ++k) {
    const Scalar measure = copied(inner, measures[k]);
    measures_.push_back(compile_canonical(measure, labels, counts, backend));
    plane += uniform(k) * measure;
  }
  plane_ =
      compile_canonical(plane, labels, {counts.unknowns, counts.elements, counts.uniforms + m + 1}, backend);
}

uint64_t TotalEnergy::fingerprint() const {
  Hash64 hash;
  hash.append(outer_.fingerprint());
  for (const symbolic::Kernel& measure : measures_) hash.append(measure.fingerprint());
  return hash.value();
}

TotalEnergy::Value TotalEnergy::evaluate(std::span<const double> totals,
                                         std::span<const double> uniforms) const {
  const int m = count();
  AlignedVector<double> lanes(static_cast<size_t>(m) * kLanes), elements(kLanes),
      out(static_cast<size_t>(outer_.output_count(Order::Hessian)) * kLanes);
  for (int k = 0; k < m; ++k) std::fill_n(lanes.begin() + k * kLanes, kLanes, totals[k]);
  outer_.evaluate(Order::Hessian, lanes.data(), elements.data(), uniforms.data(), out.data(), 1);
  Value value{.energy = out[0],
              .slopes = std::vector<double>(m),
              .curvature = std::vector<double>(static_cast<size_t>(m) * m)};
  for (int k = 0, entry = 1 + m; k < m; ++k) {
    value.slopes[k] = out[(1 + k) * kLanes];
    for (int l = k; l < m; ++l, ++entry)
      value.curvature[k * m + l] = value.curvature[l * m + k] = out[entry * kLanes];
  }
  return value;
}

}  // namespace stark
