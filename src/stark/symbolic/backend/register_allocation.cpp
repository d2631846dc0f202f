// Register allocation by furthest next use. Inputs and constants live in memory already; results that leave a
// register get a spill slot, or use their output slot, to which they were stored when they were made. An
// operand that is in memory is used from there where the instruction can, unless a register is free and the
// value is needed again. Phase: kernel building.
#include <stark/symbolic/backend/register_allocation.h>

#include <stark/base/error.h>

#include <algorithm>
#include <limits>

namespace stark::symbolic {

namespace {

constexpr int kNoUse = std::numeric_limits<int>::max();
// Dropping a value that is in memory already is cheaper than storing one: its next use counts as this much
// further.
constexpr double kHomeBonus = 2.0;

bool commutes(Code code) {
  return code == Code::Add || code == Code::Mul || code == Code::And || code == Code::Or ||
         code == Code::Xor || code == Code::AddInt;
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
    int next = 0;           // place in uses
    std::vector<int> uses;  // instructions, ascending
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
  int pick_memory_operand(const Instruction& in, const int* v, int count) const;
  uint8_t overwrite(MachineStep& s, const int* v, int count, int memory);
  void step(int i);

  const Program& program_;
  bool select_overwrites_;
  std::vector<int> holder_;  // register -> variable
  std::vector<Variable> variables_;
  std::vector<char> pinned_;
  std::vector<int> constant_, unknown_, element_, uniform_;  // index -> variable
  std::vector<int> free_spills_;
  int current_ = 0;
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
    auto& table =
        o.space == Space::Constant
            ? constant_
            : (o.space == Space::Unknown ? unknown_ : (o.space == Space::Element ? element_ : uniform_));
    if (table[o.index] < 0) {
      table[o.index] = static_cast<int>(variables_.size());
      Variable v;
      v.has_home = true;
      v.home.home =
          o.space == Space::Constant
              ? Home::Constant
              : (o.space == Space::Unknown ? Home::Unknown
                                           : (o.space == Space::Element ? Home::Element : Home::Uniform));
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
  for (int k = 0; k < static_cast<int>(program_.outputs.size()); ++k)
    variables_[visit(program_.outputs[k])].outputs.push_back(k);
  pinned_.assign(variables_.size(), 0);
}

int Allocator::variable_of(const Operand& o) const {
  switch (o.space) {
    case Space::Value:
      return o.index;
    case Space::Constant:
      return constant_[o.index];
    case Space::Unknown:
      return unknown_[o.index];
    case Space::Element:
      return element_[o.index];
    default:
      return uniform_[o.index];
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

void Allocator::load(int v) {
  MachineStep s;
  s.kind = MachineStep::Kind::Load;
  s.operands[0] = variables_[v].home;
  const int reg = take_register();
  s.target = static_cast<uint8_t>(reg);
  result_.steps.push_back(s);
  hold(v, reg);
  pinned_[v] = 1;
}

// The operand to use from memory, or -1. Called with the cursors already past this instruction.
int Allocator::pick_memory_operand(const Instruction& in, const int* v, int count) const {
  int best = -1, missing = 0;
  for (int k = 0; k < count; ++k) {
    if (variables_[v[k]].reg >= 0) continue;
    ++missing;
    bool repeated = false;
    for (int m = 0; m < count; ++m) repeated |= m != k && v[m] == v[k];
    if (repeated || !memory_allowed(in.code, k)) continue;
    if (best < 0 || next_use(v[k]) > next_use(v[best])) best = k;
  }
  if (best < 0 || next_use(v[best]) == kNoUse) return best;
  const auto free_count = std::count(holder_.begin(), holder_.end(), -1);
  return free_count > missing ? -1 : best;
}

// For instructions that overwrite an operand: picks one that dies here, or makes a copy. Returns the target
// register.
uint8_t Allocator::overwrite(MachineStep& s, const int* v, int count, int memory) {
  for (int k = 0; k < count; ++k) {
    if (k != memory && next_use(v[k]) == kNoUse) {
      s.destroyed = static_cast<int8_t>(k);
      const int reg = variables_[v[k]].reg;
      release(v[k]);
      return static_cast<uint8_t>(reg);
    }
  }
  MachineStep copy;
  const int k = memory >= 0 ? memory : 0;
  copy.kind = memory >= 0 ? MachineStep::Kind::Load : MachineStep::Kind::Move;
  copy.operands[0] = s.operands[k];
  copy.target = static_cast<uint8_t>(take_register());
  result_.steps.push_back(copy);
  s.operands[k] = {Home::Register, copy.target};
  s.destroyed = static_cast<int8_t>(k);
  return copy.target;
}

void Allocator::step(int i) {
  const Instruction& in = program_.instructions[i];
  const int count = operand_count(in.code);
  current_ = i;
  int v[3] = {-1, -1, -1};
  for (int k = 0; k < count; ++k) v[k] = variable_of(in.operands[k]);
  for (int k = 0; k < count; ++k) {
    Variable& x = variables_[v[k]];
    pinned_[v[k]] = 1;
    if (next_use(v[k]) == i) ++x.next;
  }
  const int memory = pick_memory_operand(in, v, count);
  for (int k = 0; k < count; ++k) {
    if (k != memory && variables_[v[k]].reg < 0) load(v[k]);
  }
  MachineStep s;
  s.code = in.code;
  s.shift = in.shift;
  for (int k = 0; k < count; ++k) {
    const Variable& x = variables_[v[k]];
    s.operands[k] = k == memory ? x.home : Location{Home::Register, x.reg};
  }
  int target = -1;
  if (is_fused(in.code) || (select_overwrites_ && in.code == Code::Select))
    target = overwrite(s, v, count, memory);
  for (int k = 0; k < count; ++k) {
    if (next_use(v[k]) == kNoUse && variables_[v[k]].reg >= 0) release(v[k]);
  }
  s.target = static_cast<uint8_t>(target >= 0 ? target : take_register());
  result_.steps.push_back(s);
  for (int k = 0; k < count; ++k) {
    Variable& x = variables_[v[k]];
    pinned_[v[k]] = 0;
    if (next_use(v[k]) == kNoUse && x.has_home && x.home.home == Home::Spill) {
      free_spills_.push_back(x.home.index);
      x.has_home = false;
    }
  }

  Variable& result = variables_[i];
  hold(i, s.target);
  for (const int output : result.outputs) {
    MachineStep store;
    store.kind = MachineStep::Kind::Store;
    store.target = s.target;
    store.operands[0] = {Home::Output, output};
    result_.steps.push_back(store);
    result.home = store.operands[0];
    result.has_home = true;
  }
  if (next_use(i) == kNoUse) release(i);
}

Allocation Allocator::run() {
  for (int i = 0; i < static_cast<int>(program_.instructions.size()); ++i) step(i);
  // Outputs that are inputs or constants: copied through a register at the end.
  current_ = static_cast<int>(program_.instructions.size());
  for (size_t v = program_.instructions.size(); v < variables_.size(); ++v) {
    const Variable& x = variables_[v];
    if (x.outputs.empty()) continue;
    if (x.reg < 0) load(static_cast<int>(v));
    for (const int output : x.outputs) {
      MachineStep store;
      store.kind = MachineStep::Kind::Store;
      store.target = static_cast<uint8_t>(x.reg);
      store.operands[0] = {Home::Output, output};
      result_.steps.push_back(store);
    }
    release(static_cast<int>(v));
  }
  return std::move(result_);
}

}  // namespace

Allocation allocate_registers(const Program& program, int register_count, bool select_overwrites) {
  return Allocator(program, register_count, select_overwrites).run();
}

}  // namespace stark::symbolic
