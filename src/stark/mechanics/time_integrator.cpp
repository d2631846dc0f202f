#include <stark/mechanics/time_integrator.h>

namespace stark {

TimeStencil implicit_euler(double h) { return {.scale = h, .history = 0.0}; }

TimeStencil bdf2(double h, double h_before) {
  const double w = h / h_before;
  return {.scale = h * (1.0 + w) / (1.0 + 2.0 * w), .history = w * w / (1.0 + 2.0 * w)};
}

}  // namespace stark
