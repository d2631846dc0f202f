// Conditions under which a value matters. A value that is used only inside arms of selects may be NaN or
// infinite when those arms are not taken, and so may its local derivatives; derivatives are therefore masked
// where they leave the region of such a value. A guard is a disjunction of conjunctions of conditions
// (possibly negated). Phase: kernel building.
#pragma once

#include <stark/symbolic/expr.h>

#include <cstdint>
#include <map>
#include <vector>

namespace stark::symbolic {

using GuardId = int32_t;
inline constexpr GuardId kAlways = 0, kNever = 1;

class Guards {
 public:
  using Literal = int32_t;  // 2 * condition node + (1 if negated)

  explicit Guards(Graph& graph);

  GuardId conjunction(GuardId a, GuardId b);
  GuardId conjunction(GuardId a, NodeId condition, bool value);
  GuardId disjunction(GuardId a, GuardId b);

  /// If `guard`, given that `known` holds, is one condition: true and out_literal.
  bool as_literal(GuardId guard, GuardId known, Literal& out_literal) const;
  /// Condition node of a guard, given that `known` holds. Precondition: neither kAlways nor kNever.
  NodeId condition(GuardId guard, GuardId known);

 private:
  using Conjunction = std::vector<Literal>;
  using Disjunction = std::vector<Conjunction>;
  static void simplify(Disjunction& d);
  GuardId intern(Disjunction d);
  Conjunction as_conjunction(GuardId guard);
  NodeId condition_of(const Disjunction& d);
  Conjunction remainder(GuardId guard, GuardId known) const;

  Graph& graph_;
  std::vector<Disjunction> guards_;
  std::map<Disjunction, GuardId> ids_;
};

}  // namespace stark::symbolic
