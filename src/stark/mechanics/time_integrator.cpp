#include <stark/mechanics/time_integrator.h>

#include <algorithm>

namespace stark {

TimeStencil implicit_euler(double h) { return {.scale = h, .duration = h}; }

TimeStencil bdf2(double h, double h_before) {
  const double w = h / h_before, s = h * (1.0 + w) / (1.0 + 2.0 * w);
  return {.scale = s,
          .duration = s,
          .history = w * w / (1.0 + 2.0 * w),
          .ahead = h - s,
          .lag = h - s,
          .renewal = (h - s) / h,
          .lasting = 1.0,
          .has_smooth_contact = true};
}

TimeStencil bdf2_unresolved(double h, double h_before, double lasting) {
  TimeStencil stencil = bdf2(h, h_before);
  stencil.lasting = lasting;
  stencil.contact_weight = lasting + (1.0 - lasting) * h / stencil.scale;
  stencil.has_smooth_contact = false;
  return stencil;
}

TimeStencil bdf2_impact(double h, double h_before, double lasting) {
  TimeStencil stencil = bdf2_unresolved(h, h_before, lasting);
  stencil.duration = h;
  stencil.ahead = 0.0;
  stencil.lag = h * (h / h_before);
  return stencil;
}

double smooth_part(const TimeStencil& stencil, double A_p, double p_p) {
  if (stencil.has_smooth_contact) return 1.0;
  return p_p > 0.0 ? std::clamp(-A_p / p_p, 0.0, 1.0) : 0.0;
}

}  // namespace stark
