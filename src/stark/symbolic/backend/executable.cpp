// Choice of the back end at run time. Phase: kernel building.
#include <stark/symbolic/backend/executable.h>

#include <stark/base/error.h>
#include <stark/symbolic/backend/cpu.h>

#include <string>
#include <vector>

namespace stark::symbolic {

Backend best_backend() {
  static const Backend best = [] {
    for (const Backend backend : {Backend::Avx512, Backend::Avx2, Backend::Neon})
      if (cpu_supports(backend)) return backend;
    return Backend::Interpreter;
  }();
  return best;
}

std::string to_string(Backend backend) { return stark::to_string<Backend>(backend); }

Backend resolve_backend(Backend requested) {
  if (requested == Backend::Automatic) return best_backend();
  if (requested != Backend::Interpreter && !cpu_supports(requested)) {
    throw InvalidArgument("compile: the back end " + to_string(requested) +
                          " does not exist on this machine; use automatic or " + to_string(best_backend()) +
                          ".");
  }
  return requested;
}

std::unique_ptr<Executable> make_executable(const Program& program, Backend backend, Backend& out_backend) {
  if (backend != Backend::Interpreter) {
    auto code = backend == Backend::Neon ? make_neon_code(program) : make_x86_64_code(program, backend);
    if (code) {
      out_backend = backend;
      return code;
    }
  }
  out_backend = Backend::Interpreter;
  return make_interpreter(program);
}

double* thread_scratch(size_t count) {
  thread_local std::vector<double> memory;
  if (memory.size() < count + 8) memory.resize(count + 8);
  const auto address = reinterpret_cast<uintptr_t>(memory.data());
  return memory.data() + (64 - address % 64) % 64 / sizeof(double);
}

}  // namespace stark::symbolic
