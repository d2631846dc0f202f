// Limits: stops of a coordinate. Kept within the tolerances of joints, whatever pushes; what arrives stays.
#include <stark/mechanics/define.h>

namespace stark::models {

namespace {

void keep_below(ActuatorBuilder& a) {
  a.limit(a.q() - a.parameter("upper", a.unit(), "largest value of the coordinate"));
}

void keep_above(ActuatorBuilder& a) {
  a.limit(a.parameter("lower", a.unit(), "smallest value of the coordinate") - a.q());
}

}  // namespace

ActuatorDefinition limit() {
  ActuatorDefinition definition =
      define_actuator("limit", "keeps the coordinate between two stops", [](ActuatorBuilder& a) {
        keep_above(a);
        keep_below(a);
        return Scalar(0.0);
      });
  definition.ordered = {{"lower", "upper"}};
  return definition;
}

ActuatorDefinition upper_limit() {
  return define_actuator("upper_limit", "keeps the coordinate below a stop", [](ActuatorBuilder& a) {
    keep_below(a);
    return Scalar(0.0);
  });
}

ActuatorDefinition lower_limit() {
  return define_actuator("lower_limit", "keeps the coordinate above a stop", [](ActuatorBuilder& a) {
    keep_above(a);
    return Scalar(0.0);
  });
}

}  // namespace stark::models
