// Edge pushing [Gower & Mello 2012] on the expression graph. Every node is eliminated once, users before
// operands: its adjoint and its row of second adjoints move to its operands. Contributions that are valid
// only under a condition (guards.h) are kept apart by condition and masked when the sum is used. Phase:
// kernel building.
#include <stark/symbolic/edge_pushing.h>

#include <stark/base/error.h>

#include <algorithm>

namespace stark::symbolic {

EdgePushing::EdgePushing(Graph& graph, std::span<const NodeId> targets, std::span<const Seed> seeds,
                         bool second_order)
    : graph_(graph),
      guards_(graph),
      global_(targets.begin(), targets.end()),
      target_count_(static_cast<int>(targets.size())) {
  collect(seeds);
  find_guards(seeds);
  adjoint_.assign(global_.size(), -1);
  rows_.resize(global_.size());
  for (const Seed& s : seeds) {
    if (local(s.node) >= 0) add_adjoint(local(s.node), s.adjoint, kAlways);
  }
  for (int i = static_cast<int>(global_.size()) - 1; i >= target_count_; --i) push(i, second_order);

  gradient_.resize(target_count_);
  hessian_.resize(target_count_);
  for (int i = 0; i < target_count_; ++i) {
    gradient_[i] = resolve(key(i, -1), adjoint_[i], kAlways);
    for (const Entry& e : rows_[i]) {
      const NodeId value = resolve(key(i, e.column), e.value, kAlways);
      if (value >= 0) hessian_[i].push_back({e.column, value});
    }
  }
}

// Finds the nodes that lie between the seeds and the targets.
void EdgePushing::collect(std::span<const Seed> seeds) {
  enum : signed char { kUnseen, kOpen, kPassive, kActive };
  // Operands precede their users, so nothing beyond the last seed or target is touched.
  NodeId size = 0;
  for (const Seed& s : seeds) size = std::max(size, s.node + 1);
  for (int i = 0; i < target_count_; ++i) size = std::max(size, global_[i] + 1);
  std::vector<signed char> state(size, kUnseen);
  std::vector<char> target(size, 0);
  for (int i = 0; i < target_count_; ++i) {
    state[global_[i]] = kActive;
    target[global_[i]] = 1;
  }
  const auto is_target = [&](NodeId id) { return target[id] != 0; };
  std::vector<NodeId> stack;
  for (const Seed& s : seeds) stack.push_back(s.node);
  while (!stack.empty()) {
    const NodeId id = stack.back();
    const Node& n = graph_.node(id);
    const int count = n.op == Op::Held ? 0 : operand_count(n.op);
    if (state[id] == kUnseen) {
      state[id] = kOpen;
      for (int k = n.op == Op::Select ? 1 : 0; k < count; ++k) {
        if (state[n.operands[k]] == kUnseen) stack.push_back(n.operands[k]);
      }
      continue;
    }
    stack.pop_back();
    if (state[id] != kOpen) continue;
    state[id] = kPassive;
    for (int k = n.op == Op::Select ? 1 : 0; k < count; ++k) {
      if (state[n.operands[k]] == kActive) state[id] = kActive;
    }
  }
  std::vector<int> depth(size, 0);
  for (NodeId id = 0; id < size; ++id) {
    if (state[id] != kActive) continue;
    const Node& n = graph_.node(id);
    any_choice_ |= is_choice(n.op) && !is_target(id);
    for (int k = 0; k < operand_count(n.op) && !is_target(id); ++k) {
      if (state[n.operands[k]] == kActive) depth[id] = std::max(depth[id], depth[n.operands[k]] + 1);
    }
    if (!is_target(id)) global_.push_back(id);
  }
  // Eliminating by depth keeps the matrix of second adjoints sparser than the order of creation does.
  std::stable_sort(global_.begin() + target_count_, global_.end(),
                   [&](NodeId a, NodeId b) { return depth[a] < depth[b]; });
  local_.assign(size, -1);
  for (int i = 0; i < static_cast<int>(global_.size()); ++i) local_[global_[i]] = i;
}

void EdgePushing::find_guards(std::span<const Seed> seeds) {
  target_guard_.assign(target_count_, kAlways);
  guard_.assign(global_.size(), kAlways);
  if (!any_choice_) return;
  std::fill(guard_.begin(), guard_.end(), kNever);
  for (const Seed& s : seeds) {
    if (local(s.node) >= 0) guard_[local(s.node)] = kAlways;
  }
  const auto reach = [&](NodeId operand, GuardId guard) {
    if (operand >= static_cast<NodeId>(local_.size()) || local(operand) < 0) return;
    GuardId& g = guard_[local(operand)];
    g = guards_.disjunction(g, guard);
  };
  for (int i = static_cast<int>(global_.size()) - 1; i >= target_count_; --i) {
    const Node n = graph_.node(global_[i]);
    if (is_choice(n.op)) {
      const Arms arms = choice_arms(graph_, global_[i]);
      reach(arms.taken, guards_.conjunction(guard_[i], arms.condition, true));
      reach(arms.other, guards_.conjunction(guard_[i], arms.condition, false));
    } else {
      for (int k = 0; k < operand_count(n.op); ++k) reach(n.operands[k], guard_[i]);
    }
  }
  // Results are read unconditionally, so they must be masked whatever the targets' own guards are.
  for (int i = 0; i < target_count_; ++i) {
    target_guard_[i] = guard_[i];
    guard_[i] = kAlways;
  }
}

void EdgePushing::add_adjoint(int i, NodeId value, GuardId validity) {
  if (value < 0 || graph_.is_constant(value, 0.0) || validity == kNever) return;
  if (validity == guard_[i]) {
    adjoint_[i] = add_term(graph_, adjoint_[i], value);
    return;
  }
  auto& list = conditional_[key(i, -1)];
  for (auto& c : list) {
    if (c.guard == validity) {
      c.sum = graph_.add(c.sum, value);
      return;
    }
  }
  list.push_back({validity, value});
}

void EdgePushing::add_second(int i, int j, NodeId value, GuardId validity) {
  if (value < 0 || graph_.is_constant(value, 0.0)) return;
  if (i < j) std::swap(i, j);
  auto& row = rows_[i];
  auto entry = std::find_if(row.begin(), row.end(), [&](const Entry& e) { return e.column == j; });
  if (!any_choice_ || validity == guards_.conjunction(guard_[i], guard_[j])) {
    if (entry == row.end())
      row.push_back({j, value});
    else
      entry->value = add_term(graph_, entry->value, value);
    return;
  }
  if (validity == kNever) return;
  if (entry == row.end()) row.push_back({j, -1});
  auto& list = conditional_[key(i, j)];
  for (auto& c : list) {
    if (c.guard == validity) {
      c.sum = graph_.add(c.sum, value);
      return;
    }
  }
  list.push_back({validity, value});
}

// Sum of the plain part and of the conditional parts, each masked by its condition relative to what is known.
NodeId EdgePushing::resolve(uint64_t place, NodeId plain, GuardId known) {
  if (!any_choice_) return plain;
  const auto found = conditional_.find(place);
  if (found == conditional_.end()) return plain;
  std::vector<Conditional> parts = std::move(found->second);
  conditional_.erase(found);
  const NodeId zero = graph_.constant(0.0);
  NodeId total = plain;
  for (size_t k = 0; k < parts.size(); ++k) {
    if (parts[k].sum < 0) continue;
    Guards::Literal literal, other;
    NodeId masked;
    if (guards_.as_literal(parts[k].guard, known, literal)) {
      NodeId complement = zero;  // the part under the opposite condition, if there is one
      for (size_t m = k + 1; m < parts.size(); ++m) {
        if (parts[m].sum >= 0 && guards_.as_literal(parts[m].guard, known, other) && (other ^ 1) == literal) {
          complement = parts[m].sum;
          parts[m].sum = -1;
        }
      }
      masked = literal % 2 ? graph_.select(literal / 2, complement, parts[k].sum)
                           : graph_.select(literal / 2, parts[k].sum, complement);
    } else {
      masked = graph_.select(guards_.condition(parts[k].guard, known), parts[k].sum, zero);
    }
    total = add_term(graph_, total, masked);
  }
  return total;
}

void EdgePushing::push(int i, bool second_order) {
  const NodeId id = global_[i];
  const NodeId adjoint = resolve(key(i, -1), adjoint_[i], guard_[i]);
  if (is_choice(graph_.node(id).op)) {
    push_choice(i, adjoint, second_order);
    return;
  }
  if (adjoint < 0 && rows_[i].empty()) return;
  const Partials p = local_partials(graph_, id, second_order && adjoint >= 0);
  int operand[3];
  for (int a = 0; a < p.count; ++a)
    operand[a] = p.operand[a] < static_cast<NodeId>(local_.size()) ? local(p.operand[a]) : -1;
  if (second_order) {
    const std::vector<Entry> row = std::move(rows_[i]);
    NodeId diagonal = -1;
    for (const Entry& e : row) {
      const GuardId validity = any_choice_ ? guards_.conjunction(guard_[i], guard_[e.column]) : kAlways;
      const NodeId value = resolve(key(i, e.column), e.value, validity);
      if (value < 0) continue;
      if (e.column == i) {
        diagonal = value;
        continue;
      }
      for (int a = 0; a < p.count; ++a) {
        if (operand[a] < 0) continue;
        NodeId term = multiply_term(graph_, p.first[a], value);
        if (term >= 0 && operand[a] == e.column) term = graph_.mul(graph_.constant(2.0), term);
        add_second(operand[a], e.column, term, validity);
      }
    }
    for (int a = 0; a < p.count; ++a) {
      if (operand[a] < 0) continue;
      const NodeId scaled = multiply_term(graph_, diagonal, p.first[a]);
      for (int b = a; b < p.count; ++b) {
        if (operand[b] < 0) continue;
        add_second(operand[a], operand[b], multiply_term(graph_, scaled, p.first[b]), guard_[i]);
        add_second(operand[a], operand[b], multiply_term(graph_, adjoint, p.second[a][b]), guard_[i]);
      }
    }
  }
  for (int a = 0; a < p.count; ++a) {
    if (operand[a] >= 0) add_adjoint(operand[a], multiply_term(graph_, adjoint, p.first[a]), guard_[i]);
  }
}

// A choice is linear in each arm with slope one, under the arm's condition; the arms never meet.
void EdgePushing::push_choice(int i, NodeId adjoint, bool second_order) {
  const Arms arms = choice_arms(graph_, global_[i]);
  const std::vector<Entry> row = std::move(rows_[i]);
  std::vector<std::pair<int, NodeId>> values;
  if (second_order) {
    for (const Entry& e : row) {
      const NodeId value =
          resolve(key(i, e.column), e.value, guards_.conjunction(guard_[i], guard_[e.column]));
      if (value >= 0) values.push_back({e.column, value});
    }
  }
  for (const bool taken : {true, false}) {
    const NodeId arm = taken ? arms.taken : arms.other;
    if (local(arm) < 0) continue;  // an arm is an operand, so it has a place
    const int a = local(arm);
    const GuardId validity = guards_.conjunction(guard_[i], arms.condition, taken);
    add_adjoint(a, adjoint, validity);
    for (const auto& [column, value] : values) {
      if (column == i) {
        add_second(a, a, value, validity);
      } else {
        const NodeId term = column == a ? graph_.mul(graph_.constant(2.0), value) : value;
        add_second(a, column, term, guards_.conjunction(validity, guard_[column]));
      }
    }
  }
}

}  // namespace stark::symbolic
