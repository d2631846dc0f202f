// Energy of a trial minus that of the iterate, summed element by element.
#pragma once

namespace stark {

/// Sum of energy differences and of magnitudes; the latter bounds the rounding error of the former.
struct EnergyDifference {
  double difference = 0.0;  ///< [J]
  double magnitude = 0.0;   ///< sum of |E_e| over the elements [J]
};

}  // namespace stark
