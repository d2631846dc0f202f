// Whether bodies that prescribed parts press are between two of them, or between one and something fixed, and
// have to give way; or touch one only, and could go along with it. Phase: after a step that failed.
#pragma once

#include <span>

#include <stark/contact/contact_set.h>
#include <stark/sim/model/model.h>
#include <stark/sim/scene/scene.h>

namespace stark {

/// Bodies hang together by contacts, joints and attachments, whether these hold or not. Where energies of the
/// user may hold some of them, true.
bool is_something_between(const Scene& scene, const Model& model, std::span<const Contact> contacts);

}  // namespace stark
