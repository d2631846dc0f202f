// Detection through CPUID and XGETBV [Intel SDM vol. 1, 14.3 and 15.2].
#include <stark/base/cpu.h>

#if defined(__x86_64__) && defined(__linux__)
#include <cpuid.h>

#include <cstdint>
#endif

namespace stark {

namespace {

CpuFeatures detect() {
  CpuFeatures found;
#if defined(__x86_64__) && defined(__linux__)
  unsigned a = 0, b = 0, c = 0, d = 0;
  if (!__get_cpuid(1, &a, &b, &c, &d)) return found;
  const bool has_fma = c & (1u << 12), has_xsave = c & (1u << 27), has_avx = c & (1u << 28);
  if (!has_fma || !has_xsave || !has_avx) return found;
  uint32_t low = 0, high = 0;
  __asm__ volatile("xgetbv" : "=a"(low), "=d"(high) : "c"(0));
  if ((low & 0x6) != 0x6) return found;  // xmm and ymm state
  if (!__get_cpuid_count(7, 0, &a, &b, &c, &d)) return found;
  const bool has_avx512f = b & (1u << 16), has_avx512dq = b & (1u << 17);
  found.avx2 = b & (1u << 5);
  found.avx512 = found.avx2 && has_avx512f && has_avx512dq && (low & 0xe6) == 0xe6;
#endif
  return found;
}

}  // namespace

const CpuFeatures& cpu_features() {
  static const CpuFeatures features = detect();
  return features;
}

}  // namespace stark
