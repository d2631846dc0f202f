// What this processor can execute, of what the operating system saves the registers.
#pragma once

namespace stark {

struct CpuFeatures {
  bool avx2 = false;    // with FMA
  bool avx512 = false;  // foundation (F) and DQ
};

/// Found out at the first call.
const CpuFeatures& cpu_features();

}  // namespace stark
