#include <stark/sim/contact_readings.h>

namespace stark {

const ContactReadings::Found& ContactReadings::get(std::span<const Vec3> x, uint64_t revision,
                                                   const ContactPipeline& contact, int32_t body_count) {
  const std::lock_guard lock(mutex_);
  if (revision_ == contact.revision() && revision_of_x_ == revision) return found_;
  revision_ = 0;
  found_.contacts = contact.contact_forces(x);
  found_.of_body.assign(body_count, {});
  for (int32_t c = 0; c < static_cast<int32_t>(found_.contacts.size()); ++c) {
    const Contact& both = found_.contacts[c].contact;
    found_.of_body[both.group_a].push_back(c);
    if (both.group_b != both.group_a) found_.of_body[both.group_b].push_back(c);
  }
  revision_ = contact.revision();
  revision_of_x_ = revision;
  return found_;
}

}  // namespace stark
