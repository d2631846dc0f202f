// Contacts of the last step with their forces, found once for all that ask for them before anything changes.
// Phase: queries.
#pragma once

#include <cstdint>
#include <mutex>
#include <span>
#include <vector>

#include <stark/contact/pipeline.h>

namespace stark {

class ContactReadings {
 public:
  struct Found {
    std::vector<ContactForce> contacts;
    std::vector<std::vector<int32_t>> of_body;  ///< contacts that a body has a part in, by body
  };

  /// With sites at x [m], which have this revision; valid until the next call.
  const Found& get(std::span<const Vec3> x, uint64_t revision, const ContactPipeline& contact,
                   int32_t body_count);

 private:
  std::mutex mutex_;
  Found found_;
  // Of the pipeline, which has had others since it was made, and of the positions:
  uint64_t revision_ = 0, revision_of_x_ = 0;
};

}  // namespace stark
