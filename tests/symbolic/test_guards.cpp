// Algebra of the conditions under which values matter.
#include <doctest/doctest.h>

#include <stark/symbolic/evaluate.h>
#include <stark/symbolic/guards.h>

#include "symbolic/support.h"

using namespace stark::symbolic;
using stark::symbolic::test::Random;

TEST_CASE("guards simplify") {
  Graph graph;
  const NodeId zero = graph.constant(0.0);
  NodeId c[3];
  for (NodeId& x : c) x = graph.binary(Op::Less, graph.input(InputKind::Unknown).id(), zero);
  Guards g(graph);
  const GuardId a = g.conjunction(kAlways, c[0], true), not_a = g.conjunction(kAlways, c[0], false);
  const GuardId b = g.conjunction(kAlways, c[1], true), ab = g.conjunction(a, b);
  const GuardId a_not_b = g.conjunction(a, c[1], false);

  CHECK(g.disjunction(a, not_a) == kAlways);
  CHECK(g.conjunction(a, not_a) == kNever);
  CHECK(g.disjunction(ab, a_not_b) == a);
  CHECK(g.disjunction(a, ab) == a);  // absorption
  CHECK(g.conjunction(a, ab) == ab);
  CHECK(g.conjunction(b, a) == ab);  // order does not matter
  CHECK(g.conjunction(kNever, a) == kNever);
  CHECK(g.disjunction(kNever, a) == a);
  CHECK(g.disjunction(kAlways, a) == kAlways);
  // (a and b) or (not a and b) = b, also inside a third condition.
  const GuardId in_c = g.conjunction(ab, c[2], true),
                in_c2 = g.conjunction(g.conjunction(not_a, b), c[2], true);
  CHECK(g.disjunction(in_c, in_c2) == g.conjunction(b, c[2], true));

  Guards::Literal literal = -1;
  CHECK(g.as_literal(ab, a, literal));
  CHECK(literal == 2 * c[1]);
  CHECK(g.as_literal(a_not_b, a, literal));
  CHECK(literal == 2 * c[1] + 1);
  CHECK_FALSE(g.as_literal(g.disjunction(ab, g.conjunction(not_a, c[2], true)), kAlways, literal));
  CHECK(g.condition(ab, a) == c[1]);
  CHECK(g.condition(not_a, kAlways) == graph.unary(Op::Not, c[0]));
  CHECK(g.condition(ab, kAlways) == graph.binary(Op::And, c[0], c[1]));
}

TEST_CASE("guards of many conditions stay exact") {
  // More conjunctions than are kept: (c0 and c1) or (c2 and c3) or ..., alone and with another such guard.
  constexpr int kPairs = 24;
  Graph graph;
  const NodeId zero = graph.constant(0.0);
  Guards g(graph);
  GuardId many[2] = {kNever, kNever};
  for (GuardId& guard : many) {
    for (int k = 0; k < kPairs; ++k) {
      const NodeId first = graph.binary(Op::Less, graph.input(InputKind::Unknown).id(), zero),
                   second = graph.binary(Op::Less, graph.input(InputKind::Unknown).id(), zero);
      const GuardId pair = g.conjunction(g.conjunction(kAlways, first, true), second, true);
      guard = g.disjunction(guard, pair);
    }
  }
  const NodeId one = g.condition(many[0], kAlways),
               both = g.condition(g.conjunction(many[0], many[1]), kAlways);
  Random random(7);
  int held = 0;
  for (int trial = 0; trial < 200; ++trial) {
    std::vector<double> u(4 * kPairs);
    for (double& x : u) x = random() % 6 == 0 ? -1.0 : 1.0;
    const auto expected = [&](int guard) {
      bool any = false;
      for (int k = 0; k < kPairs; ++k)
        any |= u[2 * (guard * kPairs + k)] < 0 && u[2 * (guard * kPairs + k) + 1] < 0;
      return any;
    };
    held += expected(0);
    CHECK(evaluate_condition(Scalar(&graph, one), {u}) == expected(0));
    CHECK(evaluate_condition(Scalar(&graph, both), {u}) == (expected(0) && expected(1)));
  }
  CHECK(held > 20);
  CHECK(held < 180);
}
