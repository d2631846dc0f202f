// Elementary functions as straight-line code: polynomials on top of rounding, exponent and scaling
// primitives. About one unit in the last place, the same bits on every back end, no library calls. Phase:
// kernel building.
#pragma once

#include <stark/symbolic/program.h>

namespace stark::symbolic {

LowId expand_exp(ProgramBuilder& p, LowId x);
LowId expand_log(ProgramBuilder& p, LowId x);
LowId expand_sin(ProgramBuilder& p, LowId x);  // accurate for |x| <= 1e9
LowId expand_cos(ProgramBuilder& p, LowId x);
LowId expand_tan(ProgramBuilder& p, LowId x);
LowId expand_asin(ProgramBuilder& p, LowId x);
LowId expand_acos(ProgramBuilder& p, LowId x);
LowId expand_atan(ProgramBuilder& p, LowId x);
LowId expand_atan2(ProgramBuilder& p, LowId y, LowId x);
LowId expand_tanh(ProgramBuilder& p, LowId x);
LowId expand_pow(ProgramBuilder& p, LowId x, LowId y);  // base >= 0

}  // namespace stark::symbolic
