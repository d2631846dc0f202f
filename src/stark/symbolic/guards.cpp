// Small boolean algebra in disjunctive normal form: absorption, complements, contradictions.
// Phase: kernel building.
#include <stark/symbolic/guards.h>

#include <stark/base/error.h>

#include <algorithm>
#include <iterator>
#include <utility>

namespace stark::symbolic {

namespace {

// Guards with more conjunctions than this become single conditions of the graph: as exact, but no longer
// simplified.
constexpr size_t kMaxConjunctions = 16;

bool contains(const std::vector<int32_t>& large, const std::vector<int32_t>& small) {
  return std::includes(large.begin(), large.end(), small.begin(), small.end());
}

}  // namespace

Guards::Guards(Graph& graph) : graph_(graph) {
  intern({Conjunction{}});  // kAlways
  intern({});               // kNever
}

// Merges x and c, x and not c into x; drops conjunctions implied by others; repeats until nothing changes.
void Guards::simplify(Disjunction& d) {
  for (bool changed = true; changed;) {
    changed = false;
    for (size_t i = 0; i < d.size() && !changed; ++i) {
      for (size_t j = 0; j < d.size() && !changed; ++j) {
        if (i == j) continue;
        if (contains(d[j], d[i])) {
          d.erase(d.begin() + static_cast<std::ptrdiff_t>(j));
          changed = true;
        } else if (d[i].size() == d[j].size()) {
          Conjunction difference;
          std::set_symmetric_difference(d[i].begin(), d[i].end(), d[j].begin(), d[j].end(),
                                        std::back_inserter(difference));
          if (difference.size() == 2 && difference[0] / 2 == difference[1] / 2) {
            std::erase(d[i], difference[0]);
            std::erase(d[i], difference[1]);
            d.erase(d.begin() + static_cast<std::ptrdiff_t>(j));
            changed = true;
          }
        }
      }
    }
  }
}

GuardId Guards::intern(Disjunction d) {
  simplify(d);
  std::sort(d.begin(), d.end());
  const auto [it, inserted] = ids_.try_emplace(d, static_cast<GuardId>(guards_.size()));
  if (inserted) guards_.push_back(std::move(d));
  return it->second;
}

GuardId Guards::conjunction(GuardId a, GuardId b) {
  if (a == kAlways || a == b) return b;
  if (b == kAlways) return a;
  Disjunction d;
  for (const auto& x : guards_[a]) {
    for (const auto& y : guards_[b]) {
      Conjunction both;
      std::set_union(x.begin(), x.end(), y.begin(), y.end(), std::back_inserter(both));
      bool possible = true;
      for (size_t k = 1; k < both.size(); ++k) possible &= both[k] / 2 != both[k - 1] / 2;
      if (possible) d.push_back(std::move(both));
    }
  }
  simplify(d);
  if (d.size() > kMaxConjunctions) {
    Conjunction both;
    const Conjunction x = as_conjunction(a), y = as_conjunction(b);
    std::set_union(x.begin(), x.end(), y.begin(), y.end(), std::back_inserter(both));
    d = {std::move(both)};
  }
  return intern(std::move(d));
}

GuardId Guards::conjunction(GuardId a, NodeId condition, bool value) {
  return conjunction(a, intern({Conjunction{2 * condition + (value ? 0 : 1)}}));
}

GuardId Guards::disjunction(GuardId a, GuardId b) {
  if (a == b || b == kNever) return a;
  if (a == kNever) return b;
  if (a == kAlways || b == kAlways) return kAlways;
  Disjunction d = guards_[a];
  d.insert(d.end(), guards_[b].begin(), guards_[b].end());
  simplify(d);
  if (d.size() > kMaxConjunctions) d = {{2 * condition_of(d)}};
  return intern(std::move(d));
}

// The guard as one conjunction: its own, or one condition of the graph.
Guards::Conjunction Guards::as_conjunction(GuardId guard) {
  const Disjunction& d = guards_[guard];
  return d.size() == 1 ? d[0] : Conjunction{2 * condition_of(d)};
}

Guards::Conjunction Guards::remainder(GuardId guard, GuardId known) const {
  const Disjunction& g = guards_[guard];
  const Disjunction& k = guards_[known];
  if (g.size() != 1) return {};
  if (k.size() != 1 || !contains(g[0], k[0])) return g[0];
  Conjunction rest;
  std::set_difference(g[0].begin(), g[0].end(), k[0].begin(), k[0].end(), std::back_inserter(rest));
  return rest;
}

bool Guards::as_literal(GuardId guard, GuardId known, Literal& out_literal) const {
  const Conjunction rest = remainder(guard, known);
  if (rest.size() != 1) return false;
  out_literal = rest[0];
  return true;
}

NodeId Guards::condition(GuardId guard, GuardId known) {
  STARK_CHECK(guard != kAlways && guard != kNever);
  Disjunction d = guards_[guard];
  if (d.size() == 1) d[0] = remainder(guard, known);
  return condition_of(d);
}

NodeId Guards::condition_of(const Disjunction& d) {
  NodeId any = -1;
  for (const auto& c : d) {
    NodeId all = -1;
    for (const Literal l : c) {
      const NodeId x = l % 2 ? graph_.unary(Op::Not, l / 2) : l / 2;
      all = all < 0 ? x : graph_.binary(Op::And, all, x);
    }
    STARK_CHECK(all >= 0);
    any = any < 0 ? all : graph_.binary(Op::Or, any, all);
  }
  return any;
}

}  // namespace stark::symbolic
