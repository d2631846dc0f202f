#include <stark/mechanics/canonical_kernel.h>

#include <algorithm>
#include <utility>

#include <stark/base/error.h>
#include <stark/base/hash.h>

namespace stark {

using symbolic::InputKind;
using symbolic::Scalar;

namespace {

template <typename Field>
int width_of(const std::vector<Field>& fields) {
  return fields.empty() ? 0 : fields.back().offset + fields.back().width;
}

/// Hash of the name and component of input `index`: the same wherever the field is declared.
template <typename Field>
uint64_t label_of(const std::vector<Field>& fields, int index) {
  const auto next = std::ranges::upper_bound(fields, index, {}, &Field::offset);
  STARK_CHECK(next != fields.begin());
  const Field& field = *std::prev(next);
  Hash64 hash;
  hash.append_bytes(field.name.data(), field.name.size());
  hash.append(index - field.offset);
  return hash.value();
}

}  // namespace

InputCounts input_counts(const PotentialBuilder& builder) {
  return {3 * builder.point_count(), width_of(builder.element_fields()), width_of(builder.uniform_fields())};
}

symbolic::InputLabel labels_of(const PotentialBuilder& builder) {
  return [&builder](InputKind kind, int index) -> uint64_t {
    if (kind == InputKind::Unknown) return static_cast<uint64_t>(index);
    if (kind == InputKind::Element) return label_of(builder.element_fields(), index);
    const int beyond = index - width_of(builder.uniform_fields());
    return beyond < 0 ? label_of(builder.uniform_fields(), index) : static_cast<uint64_t>(beyond);
  };
}

void add_inputs(const InputCounts& counts, symbolic::Graph& graph) {
  for (const auto& [kind, count] : {std::pair{InputKind::Unknown, counts.unknowns},
                                    {InputKind::Element, counts.elements},
                                    {InputKind::Uniform, counts.uniforms}})
    if (count > 0) graph.input_node(kind, count - 1);
}

symbolic::Kernel compile_canonical(const Scalar& energy, const symbolic::InputLabel& labels,
                                   const InputCounts& counts, symbolic::Backend backend) {
  symbolic::Graph graph;
  const Scalar copy = symbolic::canonical_copy(graph, energy, labels);
  add_inputs(counts, graph);
  // A constant energy, as that of a joint that holds nothing, has forces too: zero on all points.
  return symbolic::compile(copy.is_literal() ? Scalar(&graph, graph.constant(copy.value())) : copy, backend);
}

}  // namespace stark
