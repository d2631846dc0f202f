// Choice of the back end at run time. Phase: kernel building.
#include <stark/symbolic/backend/executable.h>

#include <stark/base/error.h>
#include <stark/symbolic/backend/cpu.h>

#include <string>
#include <vector>

namespace stark::symbolic {

Backend best_backend() {
  static const Backend best = cpu_supports(Backend::Avx512) ? Backend::Avx512
                              : cpu_supports(Backend::Avx2) ? Backend::Avx2
                                                            : Backend::Interpreter;
  return best;
}

std::string to_string(Backend backend) {
  switch (backend) {
    case Backend::Automatic:
      return "automatic";
    case Backend::Interpreter:
      return "interpreter";
    case Backend::Avx2:
      return "avx2";
    case Backend::Avx512:
      return "avx512";
  }
  return "unknown";
}

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
    if (auto code = make_machine_code(program, backend)) {
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
