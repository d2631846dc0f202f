#include <doctest/doctest.h>
#include <stark/symbolic/canonical.h>
#include <stark/symbolic/tensor.h>

#include <vector>

using namespace stark::symbolic;

namespace {

uint64_t by_number(InputKind kind, int index) { return 100 * static_cast<uint64_t>(kind) + index; }

std::vector<std::string> listing(const Graph& graph) {
  std::vector<std::string> lines;
  for (NodeId id = 0; id < graph.size(); ++id) {
    const Node& node = graph.node(id);
    lines.push_back(std::to_string(static_cast<int>(node.op)) + " " + std::to_string(node.operands[0]) + " " +
                    std::to_string(node.operands[1]) + " " + std::to_string(node.operands[2]) + " " +
                    std::to_string(node.value));
  }
  return lines;
}

/// The same energy with its parts built forwards or backwards; `stiffness` is uniform 0 or 1.
Scalar energy(Graph& graph, bool forwards, int stiffness) {
  if (!forwards) graph.input_node(InputKind::Uniform, 1 - stiffness);
  const Vec3 x = input_vector<3>(graph, InputKind::Unknown);
  const Scalar k(&graph, graph.input_node(InputKind::Uniform, stiffness));
  const Scalar rest(&graph, graph.input_node(InputKind::Uniform, 1 - stiffness));
  if (forwards) {
    const Scalar a = square(x[0] - rest), b = x[1] * sin(x[2]);
    graph.mark_stage(a);
    graph.mark_stage(b);
    return k * a + k * b + x[2] * x[2];
  }
  const Scalar last = x[2] * x[2], b = sin(x[2]) * x[1], unused = exp(x[1]);
  graph.mark_stage(b);
  graph.mark_stage(unused);
  const Scalar product = b * k, a = square(x[0] - rest);
  graph.mark_stage(a);
  return a * k + product + last;
}

}  // namespace

TEST_CASE("canonical copies of an expression are the same graph, however it was built") {
  Graph first, second, first_copy, second_copy;
  const Scalar a = energy(first, true, 0), b = energy(second, false, 1);
  CHECK(listing(first) != listing(second));
  const Scalar copy_a = canonical_copy(first_copy, a, by_number);
  // Uniforms have their numbers exchanged in the second graph: names tell them apart.
  const Scalar copy_b = canonical_copy(second_copy, b, [](InputKind kind, int index) {
    return by_number(kind, kind == InputKind::Uniform ? 1 - index : index);
  });
  std::vector<std::string> lines_a = listing(first_copy), lines_b = listing(second_copy);
  REQUIRE(lines_a.size() == lines_b.size());
  CHECK(copy_a.id() == copy_b.id());
  CHECK(first_copy.stages() == second_copy.stages());
  CHECK(first_copy.stages().size() == 2);
  for (size_t k = 0; k < lines_a.size(); ++k) {
    if (first_copy.node(k).op == Op::Uniform) {
      CHECK(first_copy.node(k).operands[0] == 1 - second_copy.node(k).operands[0]);
    } else {
      CHECK(lines_a[k] == lines_b[k]);
    }
  }
}

TEST_CASE("a canonical copy of a canonical copy is the same") {
  Graph source, once, twice;
  const Scalar copy = canonical_copy(once, energy(source, false, 0), by_number);
  const Scalar again = canonical_copy(twice, copy, by_number);
  CHECK(listing(once) == listing(twice));
  CHECK(copy.id() == again.id());
  CHECK(once.stages() == twice.stages());
}

TEST_CASE("numbers stay numbers") {
  Graph target;
  CHECK(canonical_copy(target, Scalar(2.5), by_number).is_literal());
}
