// Words of AArch64 instructions, also on processors that are not here. With STARK_AARCH64_DUMP set to a file
// name the second case writes every form with what it should say, which tests/python/test_encoder.py compares
// with an independent disassembler.
#include <stark/symbolic/backend/aarch64_assembler.h>

#include <cstdlib>
#include <fstream>
#include <functional>
#include <string>

#include <doctest/doctest.h>

using namespace stark::symbolic::aarch64;

namespace {

constexpr X kScratch{9};

uint32_t only_word(const std::function<void(Assembler&)>& write) {
  Assembler a;
  write(a);
  REQUIRE(a.size() == 4);
  uint32_t word = 0;
  for (int k = 0; k < 4; ++k) word |= static_cast<uint32_t>(a.bytes()[k]) << (8 * k);
  return word;
}

class Writer {
 public:
  explicit Writer(std::ostream& out) : out_(out) {}

  void line(const std::string& text, const std::function<void(Assembler&)>& write) {
    static const char* digits = "0123456789abcdef";
    Assembler a;
    write(a);
    out_ << text << '\t';
    for (const uint8_t byte : a.bytes()) out_ << digits[byte >> 4] << digits[byte & 15];
    out_ << '\n';
  }

 private:
  std::ostream& out_;
};

std::string v(int reg, const char* lanes) { return "v" + std::to_string(reg) + "." + lanes; }

void write_three_operands(Writer& w) {
  const std::pair<const char*, Vector> on_doubles[] = {
      {"fadd", Vector::Add},      {"fsub", Vector::Sub},           {"fmul", Vector::Mul},
      {"fdiv", Vector::Div},      {"fmla", Vector::MulAdd},        {"fmls", Vector::MulSub},
      {"fcmgt", Vector::Greater}, {"fcmge", Vector::GreaterEqual}, {"add", Vector::AddInt},
      {"sub", Vector::SubInt}};
  const std::pair<const char*, Vector> on_bits[] = {
      {"and", Vector::And},          {"bic", Vector::AndNot},
      {"eor", Vector::Xor},          {"bsl", Vector::SelectByTarget},
      {"bit", Vector::InsertIfTrue}, {"bif", Vector::InsertIfFalse}};
  const auto write = [&](const char* name, Vector op, const char* lanes) {
    for (int d = 0; d < 32; ++d)
      for (int n = 0; n < 32; n += 3)
        for (int m = 0; m < 32; m += 5)
          w.line(std::string(name) + " " + v(d, lanes) + ", " + v(n, lanes) + ", " + v(m, lanes),
                 [&](Assembler& a) { a.vector(op, d, n, m); });
  };
  for (const auto& [name, op] : on_doubles) write(name, op, "2d");
  for (const auto& [name, op] : on_bits) write(name, op, "16b");
  for (int d = 0; d < 32; ++d)
    for (int n = 0; n < 32; ++n) {
      const int m = (n + 1) % 32;
      w.line("orr " + v(d, "16b") + ", " + v(n, "16b") + ", " + v(m, "16b"),
             [&](Assembler& a) { a.vector(Vector::Or, d, n, m); });
      w.line("mov " + v(d, "16b") + ", " + v(n, "16b"), [&](Assembler& a) { a.move(d, n); });
    }
}

void write_one_operand(Writer& w) {
  const std::pair<const char*, Unary> unary[] = {
      {"fsqrt", Unary::Sqrt}, {"fneg", Unary::Negate}, {"frintn", Unary::Round}};
  for (int d = 0; d < 32; ++d)
    for (int n = 0; n < 32; ++n) {
      const std::string places = v(d, "2d") + ", " + v(n, "2d");
      for (const auto& [name, op] : unary)
        w.line(std::string(name) + " " + places, [&](Assembler& a) { a.vector(op, d, n); });
      for (const int count : {1, 11, 52, 63}) {
        const std::string by = places + ", #" + std::to_string(count);
        w.line("shl " + by, [&](Assembler& a) { a.shift_left(d, n, count); });
        w.line("ushr " + by, [&](Assembler& a) { a.shift_right(d, n, count); });
      }
    }
}

void write_memory(Writer& w) {
  for (int base = 0; base < 8; ++base)
    for (int d = 0; d < 32; ++d)
      for (const int offset : {0, 16, 256, 4096, 65520}) {
        const std::string at =
            "q" + std::to_string(d) + ", x" + std::to_string(base) + " " + std::to_string(offset);
        w.line("ldr " + at,
               [&](Assembler& a) { a.load(d, X{static_cast<uint8_t>(base)}, offset, kScratch); });
        w.line("str " + at,
               [&](Assembler& a) { a.store(d, X{static_cast<uint8_t>(base)}, offset, kScratch); });
      }
}

}  // namespace

TEST_CASE("aarch64: words of the loop") {
  CHECK(only_word([](Assembler& a) { a.ret(); }) == 0xd65f03c0);
  CHECK(only_word([](Assembler& a) { a.compare_zero(X{4}); }) == 0xf100009f);  // cmp x4, #0
  CHECK(only_word([](Assembler& a) { a.add_immediate(X{0}, 16, kScratch); }) ==
        0x91004000);  // add x0, x0, #16
  CHECK(only_word([](Assembler& a) { a.add_immediate(X{7}, -1, kScratch); }) ==
        0xd10004e7);                                                                // sub x7, x7, #1
  CHECK(only_word([](Assembler& a) { a.move_immediate(X{7}, 4); }) == 0xd2800087);  // mov x7, #4
}

TEST_CASE("aarch64: what is far takes a register") {
  Assembler a;
  a.load(3, X{1}, 65536, kScratch);  // movz, movk, ldr q3, [x1, x9]
  CHECK(a.size() == 12);
  Assembler b;
  b.add_immediate(X{2}, 4096, kScratch);  // movz, add
  CHECK(b.size() == 8);
  Assembler c;
  for (int k = 0; k < 3; ++k) c.ret();
  c.branch_if_not_zero(X{7}, 4);  // cbz x7, past; b back to 4
  CHECK(c.size() == 20);
  CHECK(c.bytes()[16] == 0xfd);  // -3 words
}

TEST_CASE("aarch64: instruction forms are written for the independent decoder") {
  const char* path = std::getenv("STARK_AARCH64_DUMP");
  if (!path) return;
  std::ofstream out(path);
  Writer writer(out);
  write_three_operands(writer);
  write_one_operand(writer);
  write_memory(writer);
  CHECK(out.good());
}
