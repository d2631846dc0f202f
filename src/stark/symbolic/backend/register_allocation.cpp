// Register allocation by furthest next use. Inputs and constants live in memory already; results that leave a register
// get a spill slot, or use their output slot, to which they were stored when they were made. An operand that is in
// memory is used from there where the instruction can, unless a register is free and the value is needed again.
// Phase: kernel building.
#include <stark/symbolic/backend/register_allocation.h>

#include <stark/base/error.h>

#include <algorithm>
#include <limits>

namespace stark::symbolic {

namespace {

constexpr int kNoUse = std::numeric_limits<int>::max();

bool commutes(Code code) {
  return code == Code::Add || code == Code::Mul || code == Code::And || code == Code::Or || code == Code::Xor || code == Code::AddInt;
}
bool is_fused(Code code) { return code >= Code::MulAdd && code <= Code::NegMulAdd; }

class Allocator {
 public:
  Allocator(const Program& program, int register_count, bool select_overwrites)
      : program_(program), select_overwrites_(select_overwrites), holder_(register_count, -1) {
    number_variables();
  }
  Allocation run();

 private:
  struct Variable {
    int reg = -1;
    bool has_home = false;
    Location home;
    int next = 0;               // place in uses
    std::vector<int> uses;      // instructions, ascending
    std::vector<int> outputs;
  };

  void number_variables();
  int variable_of(const Operand& o) const;
  int next_use(int v) const {
    const Variable& x = variables_[v];
    return x.next < static_cast<int>(x.uses.size()) ? x.uses[x.next] : kNoUse;
  }
  bool memory_allowed(Code code, int k) const;
  int find_free() const {
    for (int r = 0; r < static_cast<int>(holder_.size()); ++r) {
      if (holder_[r] < 0) return r;
    }
    return -1;
  }
  int take_register();
  void release(int v) {
    holder_[variables_[v].reg] = -1;
    variables_[v].reg = -1;
  }
  void hold(int v, int reg) {
    holder_[reg] = v;
    variables_[v].reg = reg;
  }
  void load(int v);
  void step(int i);

  const Program& program_;
  bool select_overwrites_;
  std::vector<int> holder_;  // register -> variable
  std::vector<Variable> variables_;
  std::vector<char> pinned_;
  std::vector<int> constant_, unknown_, element_, uniform_;  // index -> variable
  std::vector<int> free_spills_;
  Allocation result_;
};

void Allocator::number_variables() {
  const int n = static_cast<int>(program_.instructions.size());
  variables_.resize(n);
  constant_.assign(program_.constants.size(), -1);
  unknown_.assign(program_.unknown_count, -1);
  element_.assign(program_.element_count, -1);
  uniform_.assign(program_.uniform_count, -1);
  const auto visit = [&](const Operand& o) {
    if (o.space == Space::Value) return static_cast<int>(o.index);
    auto& table = o.space == Space::Constant ? constant_ : (o.space == Space::Unknown ? unknown_ : (o.space == Space::Element ? element_ : uniform_));
    if (table[o.index] < 0) {
      table[o.index] = static_cast<int>(variables_.size());
      Variable v;
      v.has_home = true;
      v.home.home = o.space == Space::Constant ? Home::Constant : (o.space == Space::Unknown ? Home::Unknown : (o.space == Space::Element ? Home::Element : Home::Uniform));
      v.home.index = o.index;
      variables_.push_back(v);
    }
    return table[o.index];
  };
  for (int i = 0; i < n; ++i) {
    const Instruction& in = program_.instructions[i];
    for (int k = 0; k < operand_count(in.code); ++k) {
      auto& uses = variables_[visit(in.operands[k])].uses;
      if (uses.empty() || uses.back() != i) uses.push_back(i);
    }
  }
  for (int k = 0; k < static_cast<int>(program_.outputs.size()); ++k) variables_[visit(program_.outputs[k])].outputs.push_back(k);
  pinned_.assign(variables_.size(), 0);
}

int Allocator::variable_of(const Operand& o) const {
  switch (o.space) {
    case Space::Value: return o.index;
    case Space::Constant: return constant_[o.index];
    case Space::Unknown: return unknown_[o.index];
    case Space::Element: return element_[o.index];
    default: return uniform_[o.index];
  }
}

bool Allocator::memory_allowed(Code code, int k) const {
  if (code == Code::ShiftLeft || code == Code::ShiftRight) return false;
  if (code == Code::Select) return select_overwrites_ || k == 1;
  return commutes(code) || is_fused(code) || operand_count(code) == 1 || k == 1;
}

// A register whose holder is not pinned; its value goes to memory if it is needed again and is not there yet.
int Allocator::take_register() {
  const int free_register = find_free();
  if (free_register >= 0) return free_register;
  int best = -1;
  double best_score = -1.0;
  for (int r = 0; r < static_cast<int>(holder_.size()); ++r) {
    const int v = holder_[r];
    if (pinned_[v]) continue;
    const double distance = next_use(v) == kNoUse ? 1e9 : static_cast<double>(next_use(v) - current_);
    const double score = variables_[v].has_home ? kHomeBonus * distance : distance;
    if (score > best_score) {
      best_score = score;
      best = r;
    }
  }
  STARK_CHECK(best >= 0);
  const int v = holder_[best];
  Variable& x = variables_[v];
  if (!x.has_home && next_use(v) != kNoUse) {
    int slot;
    if (free_spills_.empty()) {
      slot = result_.spill_count++;
    } else {
      slot = free_spills_.back();
      free_spills_.pop_back();
    }
    x.home = {Home::Spill, slot};
    x.has_home = true;
    MachineStep s;
    s.kind = MachineStep::Kind::Store;
    s.target = static_cast<uint8_t>(best);
    s.operands[0] = x.home;
    result_.steps.push_back(s);
  }
  release(v);
  return best;
}

}  // namespace
}  // namespace stark::symbolic
