// Simulation: attachments. Checks at time 0, forces, breaking, enabling.
#include <algorithm>
#include <limits>

#include <stark/base/error.h>
#include <stark/sim/simulation.h>

namespace stark {

namespace {

constexpr double kReleased = 0.0, kHeld = 1.0, kBroken = -1.0;

Vec3 vector_at(std::span<const double> numbers, int64_t first) {
  return {numbers[first], numbers[first + 1], numbers[first + 2]};
}

}  // namespace

void Simulation::check_attachments() {
  if (scene_.attachments().empty()) return;
  const std::vector<double> C = model_->constraints().residuals(site_positions());
  const double tolerance = joint_tolerance().length;
  for (size_t k = 0; k < scene_.attachments().size(); ++k) {
    const AttachmentDescription& attachment = scene_.attachments()[k];
    for (int32_t pair = 0; attachment.enabled && pair < attachment.size(); ++pair) {
      const int32_t number = model_->attachments()[k].first_constraint + pair;
      const double gap = norm(vector_at(C, model_->constraints().place(number).residual));
      if (!(gap <= tolerance))
        throw InvalidArgument("attachment '" + attachment.name + "': the points of pair " +
                              std::to_string(pair) + " are " + quantity_text(gap, "m") +
                              " apart at time 0: must be within " + quantity_text(tolerance, "m") +
                              "; move them together, or attach to the surface of the body");
    }
  }
}

void Simulation::commit_attachments(std::span<const Vec3> x) {
  const auto breakable = [](const AttachmentDescription& a) {
    return a.break_force < std::numeric_limits<double>::infinity();
  };
  if (std::ranges::none_of(scene_.attachments(), breakable)) return;
  const std::vector<double> reactions = model_->constraints().reactions(x);
  for (size_t k = 0; k < scene_.attachments().size(); ++k) {
    const AttachmentDescription& attachment = scene_.attachments()[k];
    const ModelAttachment& place = model_->attachments()[k];
    for (int32_t pair = 0; pair < attachment.size(); ++pair) {
      if (state_.attachment_held[place.first_pair + pair] != kHeld) continue;
      const int64_t r = model_->constraints().place(place.first_constraint + pair).residual;
      if (norm(vector_at(reactions, r)) > attachment.break_force) set_attachment_status(place, pair, kBroken);
    }
  }
}

void Simulation::set_attachment_status(const ModelAttachment& attachment, int64_t pair, double status) {
  double& held = state_.attachment_held[attachment.first_pair + pair];
  if (held == status || held == kBroken) return;
  held = status;
  const int64_t r =
      model_->constraints().place(attachment.first_constraint + static_cast<int32_t>(pair)).residual;
  std::fill_n(state_.joint_multiplier.begin() + r, 3, 0.0);
}

void Simulation::set_attachment_enabled(AttachmentId id, bool enabled) {
  const int64_t pairs = scene_.attachment(id).size();
  for (int64_t pair = 0; pair < pairs; ++pair)
    set_attachment_status(model_->attachments()[id.index], pair, enabled ? kHeld : kReleased);
}

std::vector<int32_t> Simulation::attachment_status(AttachmentId id) const {
  const int64_t pairs = scene_.attachment(id).size();
  const auto first = state_.attachment_held.begin() + model_->attachments()[id.index].first_pair;
  return {first, first + pairs};
}

std::vector<Vec3> Simulation::attachment_forces(AttachmentId id) const {
  const int64_t pairs = scene_.attachment(id).size();
  const ModelAttachment& place = model_->attachments()[id.index];
  const std::vector<double> reactions = model_->constraints().reactions(site_positions());
  std::vector<Vec3> forces(pairs);
  for (int32_t pair = 0; pair < pairs; ++pair)
    if (state_.attachment_held[place.first_pair + pair] == kHeld)  // the residual is x_a - x_b
      forces[pair] =
          -vector_at(reactions, model_->constraints().place(place.first_constraint + pair).residual);
  return forces;
}

}  // namespace stark
