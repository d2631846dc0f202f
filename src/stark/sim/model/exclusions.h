// What joints and attachments keep from contact while they hold: two bodies, or a vertex and a body. An
// exclusion ends with the last of them that holds it, as soon as both sides are apart. Phase: start of a
// step.
#pragma once

#include <cstdint>
#include <span>
#include <string>
#include <vector>

#include <stark/collision/candidates.h>
#include <stark/mechanics/state.h>
#include <stark/sim/model/model.h>
#include <stark/sim/scene/scene.h>

namespace stark {

struct Exclusion {
  static constexpr int32_t kWhole = -1;
  int32_t body = 0, vertex = kWhole;  ///< a vertex of the body, or all of it
  int32_t other = 0;                  ///< the body that it is kept from; of whole bodies the larger number
  std::vector<int32_t> joints;        ///< that hold it, by number in the scene
  std::vector<int32_t> pairs;         ///< of attachments that hold it, by place in attachment_held
  std::vector<int32_t> sewn;          ///< of pairs: those that hold it while they are released, too
  /// Of a body attached to itself: vertices that the vertex is kept from instead of all of the body, sorted.
  /// Those that carry what it is attached to, and those up to two edges from them: elsewhere the body touches
  /// itself along a seam, too.
  std::vector<int32_t> near;
};

/// Of a scene, between bodies that can touch, sorted by body, vertex and other body; `near` has the carriers
/// alone.
std::vector<Exclusion> find_exclusions(const Scene& scene, bool self_contact);

class Exclusions {
 public:
  Exclusions() = default;
  /// `base`: which bodies can touch at all.
  Exclusions(std::vector<Exclusion> list, PairFilter base, std::span<const ModelBody> bodies);

  int64_t size() const { return static_cast<int64_t>(list_.size()); }
  const Exclusion& operator[](int64_t k) const { return list_[static_cast<size_t>(k)]; }
  /// Whether a joint or a pair of an attachment holds it.
  bool is_held(int64_t k, const State& state) const;
  /// Numbers of those that nothing holds any more, sorted.
  std::vector<int64_t> released(const State& state) const;
  /// Those of them that the state says are over, sorted.
  std::vector<int64_t> over(const State& state) const;
  /// Site of its vertex, -1 of whole bodies.
  int32_t site(int64_t k) const;

  /// Whether it is about primitives with such sites of its other body.
  bool concerns(int64_t k, std::span<const int32_t> sites) const;

  /// What may touch where some of them, sorted, are over.
  PairFilter filter(std::span<const int64_t> over) const;
  /// What may touch of the bodies of some of them, sorted, with the exclusions of all others that are not
  /// over.
  PairFilter filter_between(std::span<const int64_t> some, std::span<const int64_t> over) const;

 private:
  void exclude_all_but(std::span<const int64_t> some, PairFilter& filter) const;

  std::vector<Exclusion> list_;
  PairFilter base_;
  std::vector<int32_t> first_site_;
};

}  // namespace stark
