// Building and ordering of straight-line code.
// Phase: kernel building.
#include <stark/symbolic/program.h>

#include <algorithm>
#include <bit>
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
  // Depth-first from the outputs: operands are computed shortly before their first user.
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
  return program;
}

}  // namespace stark::symbolic
