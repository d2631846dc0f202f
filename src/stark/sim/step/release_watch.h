// Contact of what joints and attachments have released comes back once it is apart (step phase 0).
#pragma once

#include <set>
#include <string>
#include <vector>

#include <stark/sim/model/exclusions.h>
#include <stark/sim/step/step_part.h>

namespace stark {

class ReleaseWatch : private StepPart {
 public:
  /// is_filled: by body, whether it fills its closed surface.
  ReleaseWatch(const StepContext& context, Exclusions exclusions, const SurfaceMesh& mesh,
               const std::vector<bool>& is_filled)
      : StepPart(context), exclusions_(std::move(exclusions)), surface_mesh_(mesh), is_filled_(is_filled) {}

  const Exclusions& exclusions() const { return exclusions_; }
  /// Throws InvalidArgument for a state whose contact_regained cannot be.
  void check(const State& state) const;
  /// Exclusions that contact does without now; sets them.
  const std::vector<int64_t>& filtered() const { return filtered_; }
  void set_regained(const std::vector<int64_t>& regained);

  /// Which exclusions are over in the step that starts from the state. Throws InitialIntersection where that
  /// is asked for and released bodies overlap.
  void begin_step();
  /// Exclusions that are over.
  const std::vector<int64_t>& regained() const { return watch_.regained; }
  const CloseBodies& close() const { return watch_.close; }
  bool has_overlap() const { return !watch_.overlapping.empty(); }
  /// "'cloth' and 'box' overlap or touch where attachment 'glue' released them".
  std::string overlap_text() const;
  /// "joint 'hinge'": what has released two bodies, named as owner_text() does; empty where nothing has.
  std::string releaser_of(const std::string& a, const std::string& b) const;

 private:
  /// Those of the released exclusions whose sides overlap or touch with sites at x.
  std::vector<int64_t> find_overlapping(const std::vector<int64_t>& released, std::span<const Vec3> x);
  bool is_vertex_inside(int64_t exclusion, std::span<const Vec3> x) const;
  /// Gives bodies that come into contact now the gap that they have for a contact distance, until they part.
  void soften_new_contact(const std::set<int64_t>& pushing, std::span<const Vec3> x);
  std::string releaser_text(const Exclusion& first) const;

  struct Watch {
    std::vector<int64_t> regained{};     ///< exclusions that are over
    std::vector<int64_t> overlapping{};  ///< those that nothing holds, of what is not apart
    CloseBodies close{};
  };

  Exclusions exclusions_;
  const SurfaceMesh& surface_mesh_;
  const std::vector<bool>& is_filled_;
  std::vector<int64_t> filtered_;  ///< exclusions that are over in the filter of contact
  Watch watch_;                    ///< of the step under way
};

/// Whether the gap of a contact is swallowed by the rounding of its coordinates.
bool is_touching(const Contact& contact, std::span<const Vec3> x);

}  // namespace stark
