// Detection through CPUID and XGETBV [Intel SDM vol. 1, 14.3 and 15.2]. Phase: kernel building.
#include <stark/symbolic/backend/cpu.h>

#if defined(__x86_64__)
#include <cpuid.h>
#endif

#include <cstdint>

namespace stark::symbolic {

bool cpu_supports(Backend backend) {
#if defined(__x86_64__) && defined(__linux__)
  unsigned a = 0, b = 0, c = 0, d = 0;
  if (!__get_cpuid(1, &a, &b, &c, &d)) return false;
  const bool has_fma = c & (1u << 12), has_xsave = c & (1u << 27), has_avx = c & (1u << 28);
  if (!has_fma || !has_xsave || !has_avx) return false;
  uint32_t low = 0, high = 0;
  __asm__ volatile("xgetbv" : "=a"(low), "=d"(high) : "c"(0));
  if ((low & 0x6) != 0x6) return false;  // xmm and ymm state
  if (!__get_cpuid_count(7, 0, &a, &b, &c, &d)) return false;
  const bool has_avx2 = b & (1u << 5), has_avx512f = b & (1u << 16), has_avx512dq = b & (1u << 17);
  if (backend == Backend::Avx2) return has_avx2;
  if (backend == Backend::Avx512) return has_avx2 && has_avx512f && has_avx512dq && (low & 0xe6) == 0xe6;
#elif defined(__aarch64__) && defined(__linux__)
  if (backend == Backend::Neon) return true;  // part of the architecture
#endif
  return backend == Backend::Interpreter || backend == Backend::Automatic;
}

}  // namespace stark::symbolic
