// Brake: holds the coordinate where it was when it was engaged, with an effort of at most cap, which it
// reaches where it has given way by `give`, and slips beyond. Energy of a step: cap/give huber(q - held,
// give), so that the effort is linear up to the cap. Held is where it would have no effort: it follows a
// coordinate that slips, at the distance give, and is memory, so that a brake that holds does not creep.
// [theory eq. 36a]
#include <stark/models/actuators/huber.h>

namespace stark::models {

ActuatorDefinition brake() {
  return define_actuator(
      "brake", "holds the coordinate with at most cap, slips beyond", [](ActuatorBuilder& a) {
        const Scalar cap = a.parameter("cap", a.effort_unit(), "largest effort", non_negative());
        const Scalar give =
            a.parameter("give", a.unit(), "change of the coordinate at which the effort is cap", positive());
        const Scalar engaged =
            a.parameter("engaged", "1", "1 holds, 0 lets go", closed_interval(0.0, 1.0), 1.0);
        const Scalar before = a.memory("engaged", "1", "whether it held in the step before");
        const Scalar held = a.memory("held", a.unit(), "coordinate without effort");
        const Scalar start = select(before > 0.5, held, a.q_start());
        const Scalar stretch = a.q() - start;
        a.remember("held", a.q() - max(-give, min(stretch, give)));
        a.remember("engaged", select(engaged > 0.5, Scalar(1.0), Scalar(0.0)));
        return select(engaged > 0.5, cap / give * huber(stretch, give), Scalar(0.0) * a.q());
      });
}

}  // namespace stark::models
