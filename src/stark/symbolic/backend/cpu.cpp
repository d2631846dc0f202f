// Back ends by features of the processor. Phase: kernel building.
#include <stark/symbolic/backend/cpu.h>

#include <stark/base/cpu.h>

namespace stark::symbolic {

bool cpu_supports(Backend backend) {
  if (backend == Backend::Avx2) return cpu_features().avx2;
  if (backend == Backend::Avx512) return cpu_features().avx512;
#if defined(__aarch64__) && defined(__linux__)
  if (backend == Backend::Neon) return true;  // part of the architecture
#endif
  return backend == Backend::Interpreter || backend == Backend::Automatic;
}

}  // namespace stark::symbolic
