// Constraints that hold what they find: joints and pairs of attachments that are released at time 0 and hold
// from any step on, at the place that side a has then on the carrier of side b. Their frames b are
// FrameKind::Placed; the numbers of the places are in the state, so that rewinding and resuming know them.
// Phase: between steps.
#pragma once

#include <span>
#include <vector>

#include <stark/mechanics/constraint_set.h>
#include <stark/sim/model/model.h>
#include <stark/sim/scene/attachment.h>
#include <stark/sim/scene/joint.h>

namespace stark {

/// Whether a joint can hold what it finds: it is released at time 0, all that it holds is that its frames
/// coincide, or their origins, and side b is rigid.
bool can_hold_here(const JointDescription& joint);
/// The same of pairs that `points`, some of side b, carry.
bool can_hold_here(const AttachmentDescription& attachment, const PointSet& points);

/// Where side a is at x on the carrier of side b, and how it is turned there: kPlaceNumbers, or the position
/// alone.
std::vector<double> find_place(const ConstraintSet& constraints, const HeldPlace& place,
                               std::span<const Vec3> x);

/// Gives an element with a frame b of FrameKind::Placed a place: kPlaceNumbers, or a position without a turn.
void set_place(PotentialBatch& batch, int64_t element, std::span<const double> numbers);
/// The same of all constraints that have one; `numbers` as in State::held_place.
void set_places(ConstraintSet& constraints, std::span<const HeldPlace> places,
                std::span<const double> numbers);

/// How many numbers a place has.
inline int64_t width_of(const HeldPlace& place) { return place.has_axes ? kPlaceNumbers : 3; }

}  // namespace stark
