// Register allocation by furthest next use. Inputs and constants live in memory already; results that leave a
// register get a spill slot, or use their output slot, to which they were stored when they were made. An
// operand that is in memory is used from there where the instruction can, unless a register is free and the
// value is needed again. Phase: kernel building.
#include <stark/symbolic/backend/register_allocation.h>

#include <stark/base/error.h>

#include <algorithm>
#include <array>
#include <limits>
#include <utility>

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
    int next = 0, end = 0;  // uses that are left: a range of uses_
    int first_output = -1;  // list of outputs that are this variable, linked by next_output_
  };

  void number_variables();
  int variable_of(const Operand& o) const { return first_[static_cast<int>(o.space)] + o.index; }
  int next_use(int v) const {
    const Variable& x = variables_[v];
    return x.next < x.end ? uses_[x.next] : kNoUse;
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
  std::array<int, 6> first_{};  // variable of the first operand of each space
  std::vector<int> uses_;       // instructions, ascending, by variable
  std::vector<int> next_output_;
  std::vector<int> free_spills_;
  int current_ = 0;
  Allocation result_;
};

void Allocator::number_variables() {
  const int n = static_cast<int>(program_.instructions.size());
  int count = 0;
  const auto add_space = [&](Space space, Home home, int size) {
    first_[static_cast<int>(space)] = count;
    variables_.resize(static_cast<size_t>(count + size));
    for (int k = 0; k < size && home != Home::Register; ++k) {
      variables_[count + k].has_home = true;
      variables_[count + k].home = {home, k};
    }
    count += size;
  };
  add_space(Space::Value, Home::Register, n);
  add_space(Space::Constant, Home::Constant, static_cast<int>(program_.constants.size()));
  add_space(Space::Unknown, Home::Unknown, program_.unknown_count);
  add_space(Space::Element, Home::Element, program_.element_count);
  add_space(Space::Uniform, Home::Uniform, program_.uniform_count);
  pinned_.assign(variables_.size(), 0);

  // Uses by variable: count, then fill.
  for (const Instruction& in : program_.instructions) {
    for (int k = 0; k < operand_count(in.code); ++k) ++variables_[variable_of(in.operands[k])].end;
  }
  int begin = 0;
  for (Variable& v : variables_) {
    const int size = v.end;
    v.next = v.end = begin;
    begin += size;
  }
  uses_.resize(static_cast<size_t>(begin));
  for (int i = 0; i < n; ++i) {
    const Instruction& in = program_.instructions[i];
    for (int k = 0; k < operand_count(in.code); ++k) {
      Variable& v = variables_[variable_of(in.operands[k])];
      if (v.end == v.next || uses_[v.end - 1] != i) uses_[v.end++] = i;
    }
  }
  next_output_.resize(program_.outputs.size());
  for (int k = static_cast<int>(program_.outputs.size()) - 1; k >= 0; --k) {
    Variable& v = variables_[variable_of(program_.outputs[k])];
    next_output_[k] = v.first_output;
    v.first_output = k;
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
  for (int output = result.first_output; output >= 0; output = next_output_[output]) {
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
    if (x.first_output < 0) continue;
    if (x.reg < 0) load(static_cast<int>(v));
    for (int output = x.first_output; output >= 0; output = next_output_[output]) {
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
