// Contacts of the last step with their forces, found once for all that ask for them before anything changes.
// Phase: queries.
#pragma once

#include <cstdint>
#include <mutex>
#include <span>
#include <vector>

#include <stark/contact/pipeline.h>
#include <stark/mechanics/state.h>

namespace stark {

class ContactReadings {
 public:
  struct Found {
    std::vector<ContactForce> contacts;
    std::vector<Vec3> x;                        ///< by site [m]
    std::vector<std::vector<int32_t>> of_body;  ///< contacts that a body has a part in, by body
  };

  /// Of a state with sites at `positions()`; valid until the next call.
  template <typename Positions>
  const Found& get(const State& state, const ContactPipeline& contact, int32_t body_count,
                   Positions&& positions) {
    const std::lock_guard lock(mutex_);
    if (!is_of(state, contact)) find(state, contact, body_count, positions());
    return found_;
  }

 private:
  bool is_of(const State& state, const ContactPipeline& contact) const;
  void find(const State& state, const ContactPipeline& contact, int32_t body_count, std::vector<Vec3> x);

  std::mutex mutex_;
  Found found_;
  uint64_t revision_ = 0;  ///< of the pipeline; it has had others since it was made
  // What x follows from:
  std::vector<Vec3> point_position_, body_position_;
  std::vector<Mat3> body_rotation_;
};

}  // namespace stark
