// Building and ordering of straight-line code.
// Phase: kernel building.
#include <stark/symbolic/program.h>

#include <algorithm>
#include <bit>
#include <queue>
#include <utility>

namespace stark::symbolic {

ProgramBuilder::ProgramBuilder() : table_(2048, -1) { items_.reserve(1024); }

uint64_t ProgramBuilder::hash(const Item& item) {
  uint64_t h = item.payload + static_cast<uint64_t>(item.space) * 0x9e3779b97f4a7c15ull;
  const uint64_t words[] = {static_cast<uint64_t>(static_cast<uint32_t>(item.operands[0])) << 32 |
                                static_cast<uint32_t>(item.operands[1]),
                            static_cast<uint64_t>(static_cast<uint32_t>(item.operands[2])) << 32 |
                                static_cast<uint64_t>(item.code) << 8 | item.shift};
  for (const uint64_t w : words) {
    h = (h ^ w) * 0x9e3779b97f4a7c15ull;
    h ^= h >> 31;
  }
  h *= 0xbf58476d1ce4e5b9ull;
  return h ^ (h >> 30);
}

LowId ProgramBuilder::intern(const Item& item) {
  if (2 * items_.size() >= table_.size()) {
    std::vector<LowId> table(2 * table_.size(), -1);
    for (LowId id = 0; id < static_cast<LowId>(items_.size()); ++id) {
      uint64_t slot = hash(items_[id]) & (table.size() - 1);
      while (table[slot] >= 0) slot = (slot + 1) & (table.size() - 1);
      table[slot] = id;
    }
    table_ = std::move(table);
  }
  uint64_t slot = hash(item) & (table_.size() - 1);
  for (; table_[slot] >= 0; slot = (slot + 1) & (table_.size() - 1)) {
    if (items_[table_[slot]] == item) return table_[slot];
  }
  table_[slot] = static_cast<LowId>(items_.size());
  items_.push_back(item);
  return table_[slot];
}

LowId ProgramBuilder::bits(uint64_t value) {
  Item item;
  item.space = Space::Constant;
  item.payload = value;
  return intern(item);
}

LowId ProgramBuilder::constant(double value) { return bits(std::bit_cast<uint64_t>(value)); }

LowId ProgramBuilder::input(Space space, int index) {
  Item item;
  item.space = space;
  item.payload = static_cast<uint64_t>(index);
  return intern(item);
}

LowId ProgramBuilder::emit(Code code, LowId a, LowId b, LowId c, int shift) {
  Item item;
  item.space = Space::Value;
  item.code = code;
  item.shift = static_cast<uint8_t>(shift);
  const bool commutes = code == Code::Add || code == Code::Mul || code == Code::And || code == Code::Or ||
                        code == Code::Xor || code == Code::AddInt ||
                        (code >= Code::MulAdd && code <= Code::NegMulAdd);
  if (commutes && a > b) std::swap(a, b);
  item.operands[0] = a;
  item.operands[1] = b;
  item.operands[2] = c;
  return intern(item);
}

LowId ProgramBuilder::select(LowId mask, LowId a, LowId b) {
  // Where one side is +0 a masking does the same.
  const auto is_zero = [&](LowId x) { return items_[x].space == Space::Constant && items_[x].payload == 0; };
  if (is_zero(b)) return emit(Code::And, mask, a);
  if (is_zero(a)) return emit(Code::AndNot, mask, b);
  return emit(Code::Select, mask, a, b);
}

Program ProgramBuilder::finish(std::span<const LowId> outputs) const {
  // Depth-first from the outputs, so that operands come shortly before their first user; then refined.
  Program program;
  std::vector<Operand> place(items_.size());
  std::vector<char> seen(items_.size(), 0);
  std::vector<LowId> stack;
  const auto finish_item = [&](LowId id) {
    const Item& item = items_[id];
    if (item.space == Space::Constant) {
      place[id] = {Space::Constant, static_cast<int32_t>(program.constants.size())};
      program.constants.push_back(item.payload);
    } else if (item.space != Space::Value) {
      place[id] = {item.space, static_cast<int32_t>(item.payload)};
    } else {
      Instruction instruction;
      instruction.code = item.code;
      instruction.shift = item.shift;
      for (int k = 0; k < operand_count(item.code); ++k) instruction.operands[k] = place[item.operands[k]];
      place[id] = {Space::Value, static_cast<int32_t>(program.instructions.size())};
      program.instructions.push_back(instruction);
    }
  };
  for (const LowId root : outputs) {
    stack.push_back(root);
    while (!stack.empty()) {
      const LowId id = stack.back();
      if (seen[id] == 2) {
        stack.pop_back();
      } else if (seen[id] == 1) {
        stack.pop_back();
        seen[id] = 2;
        finish_item(id);
      } else {
        seen[id] = 1;
        const Item& item = items_[id];
        for (int k = 2; k >= 0; --k) {
          if (item.operands[k] >= 0 && !seen[item.operands[k]]) stack.push_back(item.operands[k]);
        }
      }
    }
  }
  for (const LowId id : outputs) program.outputs.push_back(place[id]);
  reorder(program);
  return program;
}

namespace {

// Order of the instructions of a program, last to first. An instruction is eligible when all its users are
// placed; among those the one is taken that lets the fewest values become alive (its operands that no placed
// instruction uses yet), later ones first. Keeps about a tenth fewer values in memory than the depth-first
// order alone.
class BottomUpOrder {
 public:
  explicit BottomUpOrder(const Program& program)
      : program_(program), pending_(size(), 0), alive_(size(), 0), eligible_(size(), 0) {
    for (int i = 0; i < size(); ++i) {
      for_operands(i, [&](int o) { ++pending_[o]; });
    }
    // Users by operand, as ranges of one array.
    first_user_.assign(static_cast<size_t>(size()) + 1, 0);
    for (int o = 0; o < size(); ++o) first_user_[o + 1] = first_user_[o] + pending_[o];
    users_.resize(static_cast<size_t>(first_user_.back()));
    std::vector<int> fill(first_user_.begin(), first_user_.end() - 1);
    for (int i = 0; i < size(); ++i) {
      for_operands(i, [&](int o) { users_[fill[o]++] = i; });
    }
  }

  std::vector<int> run() {
    for (int i = 0; i < size(); ++i) {
      if (pending_[i] == 0) insert(i);
    }
    std::vector<int> order;
    while (!queue_.empty()) {
      const auto [score, i] = queue_.top();
      queue_.pop();
      if (!eligible_[i] || score != score_of(i)) continue;  // an outdated entry
      eligible_[i] = 0;
      order.push_back(i);
      for_operands(i, [&](int o) {
        if (!alive_[o]) {
          alive_[o] = 1;
          for (int k = first_user_[o]; k < first_user_[o + 1]; ++k) {
            if (eligible_[users_[k]]) insert(users_[k]);
          }
        }
        if (--pending_[o] == 0) insert(o);
      });
    }
    std::reverse(order.begin(), order.end());
    return order;
  }

 private:
  int size() const { return static_cast<int>(program_.instructions.size()); }
  template <typename F>
  void for_operands(int i, F f) const {  // distinct values only
    const Instruction& in = program_.instructions[i];
    for (int k = 0; k < operand_count(in.code); ++k) {
      const Operand& o = in.operands[k];
      bool repeated = false;
      for (int m = 0; m < k; ++m) repeated |= in.operands[m] == o;
      if (o.space == Space::Value && !repeated) f(o.index);
    }
  }
  int score_of(int i) const {
    int score = alive_[i] ? 1 : 0;
    for_operands(i, [&](int o) { score -= alive_[o] ? 0 : 1; });
    return score;
  }
  void insert(int i) {
    eligible_[i] = 1;
    queue_.push({score_of(i), i});
  }

  const Program& program_;
  std::vector<int> pending_;  // users that are not placed yet
  std::vector<char> alive_, eligible_;
  std::vector<int> first_user_, users_;
  std::priority_queue<std::pair<int, int>> queue_;
};

}  // namespace

void reorder(Program& program) {
  const std::vector<int> order = BottomUpOrder(program).run();
  std::vector<int> place(order.size());
  for (size_t k = 0; k < order.size(); ++k) place[order[k]] = static_cast<int>(k);
  const auto renumber = [&](Operand& o) {
    if (o.space == Space::Value) o.index = place[o.index];
  };
  std::vector<Instruction> instructions;
  instructions.reserve(order.size());
  for (const int i : order) {
    instructions.push_back(program.instructions[i]);
    for (Operand& o : instructions.back().operands) renumber(o);
  }
  program.instructions = std::move(instructions);
  for (Operand& o : program.outputs) renumber(o);
}

}  // namespace stark::symbolic
