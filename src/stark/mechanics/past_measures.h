// Rates in formulas that do not know of integrators, as users write them: (g(x) - g(x_prev)) / h. With a
// history, g at the extrapolated x_prev is not the extrapolated g; these are found and replaced by what
// PotentialBuilder::reference makes of them. Phase: model building. [theory eq. 26b]
#pragma once

#include <stark/mechanics/potential.h>

namespace stark {

/// `energy`, written with `builder`, with the reference in place of every measure of the past: the largest
/// subexpressions of x_prev alone that are not linear in it. Those that are references already stay, and so
/// do conditions. What has jumped, as an angle does by a turn, is left as it is.
symbolic::Scalar with_references(PotentialBuilder& builder, const symbolic::Scalar& energy);

}  // namespace stark
