// The seam between programs and the machines that run them. Phase: kernel building; run() in every assembly.
#pragma once

#include <stark/symbolic/kernel.h>
#include <stark/symbolic/program.h>

#include <cstddef>
#include <cstdint>
#include <memory>

namespace stark::symbolic {

class Executable {
 public:
  virtual ~Executable() = default;
  /// Array layout as Kernel::evaluate. Safe to call from several threads.
  virtual void run(const double* unknowns, const double* elements, const double* uniforms, double* out_values,
                   int64_t block_count) const = 0;
  size_t code_bytes = 0;
  int spill_slots = 0;
};

std::unique_ptr<Executable> make_interpreter(const Program& program);

/// Machine code; null on other machines and where this one refuses executable memory.
std::unique_ptr<Executable> make_x86_64_code(const Program& program, Backend backend);
std::unique_ptr<Executable> make_neon_code(const Program& program);

/// Back end that `requested` stands for here. Throws InvalidArgument if this machine does not have it.
Backend resolve_backend(Backend requested);
/// Machine code where possible, else the interpreter; out_backend says which.
std::unique_ptr<Executable> make_executable(const Program& program, Backend backend, Backend& out_backend);

/// Scratch memory of this thread, aligned to 64 bytes, valid until the next call in this thread.
double* thread_scratch(size_t count);

}  // namespace stark::symbolic
