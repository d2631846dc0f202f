#include <stark/mechanics/canonical_kernel.h>

#include <utility>

#include <stark/base/hash.h>

namespace stark {

using symbolic::InputKind;
using symbolic::Scalar;

namespace {

/// Hash of the name and component of input `index`: the same wherever the field is declared.
template <typename Field>
uint64_t label_of(const std::vector<Field>& fields, int index) {
  const Field& field = field_at(fields, index);
  Hash64 hash;
  hash.append_bytes(field.name.data(), field.name.size());
  hash.append(index - field.offset);
  return hash.value();
}

}  // namespace

InputCounts input_counts(const PotentialBuilder& builder) {
  return {3 * builder.point_count(), total_width(builder.element_fields()),
          total_width(builder.uniform_fields())};
}

symbolic::InputLabel labels_of(const PotentialBuilder& builder) {
  return [&builder](InputKind kind, int index) -> uint64_t {
    if (kind == InputKind::Unknown) return static_cast<uint64_t>(index);
    if (kind == InputKind::Element) return label_of(builder.element_fields(), index);
    const int beyond = index - total_width(builder.uniform_fields());
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
