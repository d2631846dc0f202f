#include <stark/sim/contact_readings.h>

#include <utility>

namespace stark {

bool ContactReadings::is_of(const State& state, const ContactPipeline& contact) const {
  return revision_ == contact.revision() && body_position_ == state.body_position &&
         body_rotation_ == state.body_rotation && point_position_ == state.point_position;
}

void ContactReadings::find(const State& state, const ContactPipeline& contact, int32_t body_count,
                           std::vector<Vec3> x) {
  revision_ = 0;
  found_.contacts = contact.contact_forces(x);
  found_.x = std::move(x);
  found_.of_body.assign(body_count, {});
  for (int32_t c = 0; c < static_cast<int32_t>(found_.contacts.size()); ++c) {
    const Contact& both = found_.contacts[c].contact;
    found_.of_body[both.group_a].push_back(c);
    if (both.group_b != both.group_a) found_.of_body[both.group_b].push_back(c);
  }
  body_position_ = state.body_position;
  body_rotation_ = state.body_rotation;
  point_position_ = state.point_position;
  revision_ = contact.revision();
}

}  // namespace stark
