// Simulation: attachments. Checks at time 0, forces, breaking, enabling.
#include <algorithm>
#include <limits>

#include <stark/base/error.h>
#include <stark/sim/simulation_parts.h>

namespace stark {

namespace {

constexpr int64_t kRows = 3;  ///< residuals of a pair

Vec3 vector_at(std::span<const double> numbers, int64_t first) {
  return {numbers[first], numbers[first + 1], numbers[first + 2]};
}

}  // namespace

void Simulation::check_attachments() {
  if (scene_.attachments().empty()) return;
  const std::vector<double> C = energies_.constraints.residuals(site_positions());
  const double tolerance = joint_tolerance(settings_.joints).length;
  for (size_t k = 0; k < scene_.attachments().size(); ++k) {
    const AttachmentDescription& attachment = scene_.attachments()[k];
    for (int32_t pair = 0; attachment.enabled && pair < attachment.size(); ++pair) {
      const int32_t number = model_->attachments()[k].first_constraint + pair;
      const double gap = norm(vector_at(C, energies_.constraints.place(number).residual));
      if (!(gap <= tolerance))
        throw InvalidArgument("attachment '" + attachment.name + "': the points of pair " +
                              std::to_string(pair) + " are " + quantity_text(gap, "m") +
                              " apart at time 0: must be within " + quantity_text(tolerance, "m") +
                              "; move them together, or attach to the surface of the body");
    }
  }
}

void Simulation::check_attachment_agrees(AttachmentId id) const {
  const AttachmentDescription& attachment = scene_.attachment(id);
  const ModelAttachment& place = model_->attachments()[id.index];
  const std::vector<double> gaps = attachment_gaps(id);
  const double tolerance = joint_tolerance(settings_.joints).length;
  int32_t released = 0, apart = 0, farthest = -1;
  double largest = 0.0;
  for (int32_t pair = 0; pair < attachment.size(); ++pair) {
    if (state_.attachment_held[place.first_pair + pair] != kReleased) continue;
    ++released;
    if (gaps[pair] <= tolerance) continue;
    ++apart;
    if (!(gaps[pair] <= largest)) largest = gaps[pair], farthest = pair;
  }
  if (apart == 0) return;
  throw InvalidArgument("attachment '" + attachment.name + "': " + std::to_string(apart) + " of " +
                        std::to_string(released) + " released pairs are away from where " +
                        (attachment.sewn ? "they meet" : "they were attached at time 0") + ", pair " +
                        std::to_string(farthest) + " by " + rough_text(largest, "m") + ": must be within " +
                        quantity_text(tolerance, "m") +
                        " to be held again, as the next step would throw them there; bring them there first, "
                        "or pull_together() if that is meant");
}

std::vector<double> Simulation::attachment_gaps(AttachmentId id) const {
  const int32_t pairs = scene_.attachment(id).size(),
                first = model_->attachments()[id.index].first_constraint;
  const std::vector<double> C = energies_.constraints.residuals_of(first, pairs, site_positions());
  std::vector<double> gaps(pairs);
  for (int32_t pair = 0; pair < pairs; ++pair) gaps[pair] = norm(vector_at(C, kRows * pair));
  return gaps;
}

void Simulation::set_attachment_enabled(AttachmentId id, bool enabled) {
  const int64_t pairs = scene_.attachment(id).size();
  for (int64_t pair = 0; pair < pairs; ++pair)
    parts_->joints.set_attachment_status(model_->attachments()[id.index], pair, enabled ? kHeld : kReleased);
}

void Simulation::check_pairs(AttachmentId id, std::span<const int32_t> pairs) const {
  const AttachmentDescription& attachment = scene_.attachment(id);
  for (const int32_t pair : pairs)
    if (pair < 0 || pair >= attachment.size())
      throw InvalidArgument("attachment '" + attachment.name + "': pair " + std::to_string(pair) +
                            ": must be in [0, " + std::to_string(attachment.size()) + ")");
}

void Simulation::hold_pairs_here(AttachmentId id, std::span<const int32_t> pairs) {
  const AttachmentDescription& attachment = scene_.attachment(id);
  const ModelAttachment& place = model_->attachments()[id.index];
  const std::string owner = "attachment '" + attachment.name + "'";
  check_pairs(id, pairs);
  for (const int32_t pair : pairs) {
    if (!find_held_place(place.first_constraint + pair))
      throw InvalidArgument(
          owner +
          (attachment.enabled
               ? ": it holds from time 0 on, at the places that it has there: add it with enabled = "
                 "false to hold what it finds later"
               : ": what carries pair " + std::to_string(pair) +
                     " is not rigid: pairs hold what they find on a rigid body, a node of a rod or the "
                     "world; exchange the sides if the other one is rigid"));
    if (state_.attachment_held[place.first_pair + pair] == kBroken)
      throw InvalidArgument(owner + ": pair " + std::to_string(pair) +
                            " has broken: it cannot hold anything any more; rewind, or leave it out");
  }
  const std::vector<Vec3> x = site_positions();
  for (const int32_t pair : pairs) {
    take_place(*find_held_place(place.first_constraint + pair), x);
    parts_->joints.set_attachment_status(place, pair, kHeld);
  }
}

void Simulation::release_pairs(AttachmentId id, std::span<const int32_t> pairs) {
  check_pairs(id, pairs);
  for (const int32_t pair : pairs)
    parts_->joints.set_attachment_status(model_->attachments()[id.index], pair, kReleased);
}

std::vector<int32_t> Simulation::attachment_status(AttachmentId id) const {
  const int64_t pairs = scene_.attachment(id).size();
  const auto first = state_.attachment_held.begin() + model_->attachments()[id.index].first_pair;
  return {first, first + pairs};
}

std::vector<Vec3> Simulation::attachment_forces(AttachmentId id) const {
  const int32_t pairs = scene_.attachment(id).size(),
                first = model_->attachments()[id.index].first_constraint;
  const std::vector<double> reactions = energies_.constraints.reactions_of(first, pairs, site_positions());
  std::vector<Vec3> forces(pairs);
  for (int32_t pair = 0; pair < pairs; ++pair)  // the residual is x_a - x_b; no minus before zeros of pairs
    forces[pair] = Vec3{} - vector_at(reactions, kRows * pair);  // that do not hold
  return forces;
}

}  // namespace stark
