// Time integrators as coefficients: how the velocity and the inertia of a step follow from positions (step
// phase 2). All of them are minimisations of the same potential (theory eq. 1, 2), with
//     x_bar = x + b v - l Q,   v_new = (x_new - x_bar) / sigma,   x_hat = x_bar + sigma (v + c A),
// where A is the increment of the velocity in the last step, and Q is what the velocity at its end was ahead
// of the mean one. Where steps resolve contact, all forces push with s. Where they do not, A leaves out what
// contact did suddenly, which pushes with the whole step h: an impact has no history that would throw bodies
// apart again.
// Damping measures displacements from x_bar over the time sigma, so that it sees exactly the velocity.
#pragma once

#include <stark/base/math.h>
#include <stark/base/settings.h>

namespace stark {

/// Implicit Euler, backward differences of order 2, or a sequence of equilibria without inertia.
enum class Integrator : uint8_t { ImplicitEuler, Bdf2, Quasistatic };
template <>
struct EnumNames<Integrator> {
  static constexpr std::array<std::string_view, 3> kNames{"implicit_euler", "bdf2", "quasistatic"};
};

/// Whether inertia and damping act, so that the length of a step means something.
constexpr bool has_inertia(Integrator integrator) { return integrator != Integrator::Quasistatic; }
/// Whether steps go on from what the one before did, which the state then keeps.
constexpr bool has_history(Integrator integrator) { return integrator == Integrator::Bdf2; }

struct TimeStencil {
  double scale = 0.0;           ///< s [s]
  double duration = 0.0;        ///< sigma [s]
  double history = 0.0;         ///< c, zero when the step before has no say
  double ahead = 0.0;           ///< b [s]
  double lag = 0.0;             ///< l [s]
  double renewal = 0.5;         ///< of Q by increments: b/h of BDF2, 1/3 for equal steps
  double contact_weight = 1.0;  ///< h/s where A leaves contact out altogether
  double lasting = 0.0;         ///< share of the increment by contact that A takes in
  bool has_smooth_contact = false;

  /// x_bar and v_bar; x and v in every bit when the history has no say.
  template <typename T>
  T place(const T& x, const T& v, const T& Q) const {
    return history == 0.0 ? x : x + v * ahead - Q * lag;
  }
  /// A: the increment by all but contact, p: by contact.
  template <typename T>
  T velocity(const T& v, const T& A, const T& p) const {
    if (history == 0.0) return v;
    return v + (A + p * lasting) * history;
  }
  /// What contact has made of a velocity: of its forces in this step, and of the last increment where that
  /// is part of v_bar.
  template <typename T>
  T by_contact(const T& p, const T& now) const {
    return p * (lasting * history) + now;
  }
};

/// s = sigma = h, no history: order 1, strongly damping, no memory.
TimeStencil implicit_euler(double h);

/// Backward differences of order 2 with variable steps: w = h / h_before, s = sigma = h (1 + w)/(1 + 2 w)
/// and c = w^2/(1 + 2 w); 2h/3 and 1/3 for equal steps. [Hairer, Norsett, Wanner 1993, sec. III.5]
TimeStencil bdf2(double h, double h_before);

/// The same where contact comes and goes within steps, all at once, but for the share that lasts.
TimeStencil bdf2_unresolved(double h, double h_before, double lasting = 0.0);

/// That with sigma = h: of order 2 in smooth motion, and what is stopped by an impact within the step
/// has no velocity left at its end, where x_bar of bdf2 is ahead by h/3 of it.
TimeStencil bdf2_impact(double h, double h_before, double lasting = 0.0);

/// Steps that grow faster than this start again with implicit Euler: zero-stability of BDF2 ends at 2.41.
inline constexpr double kLargestBdf2Ratio = 2.0;

/// Q at the end of a step, from that of the last one, the smooth increment A of this one and the increment p
/// that contact made, of which the part counts that A takes back: contact that lasts is smooth, impacts are
/// not. `part` is that of smooth_part(). After a step without history A and p alone count.
template <typename T>
T next_lag(const TimeStencil& stencil, const T& Q, const T& A, const T& p, double part) {
  const T increment = A + p * part;
  return (stencil.history == 0.0 ? increment : Q + increment) * stencil.renewal;
}

/// 1 where steps resolve contact; else -<A, p>/<p, p>, cut to [0, 1]; 0 where p is. The products are those of
/// kinetic energy.
double smooth_part(const TimeStencil& stencil, double A_p, double p_p);

}  // namespace stark
