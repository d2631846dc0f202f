#include <stark/sim/step/not_finite.h>

#include <algorithm>
#include <cmath>

#include <stark/base/error.h>
#include <stark/sim/scene/body_checks.h>

namespace stark {

namespace {

constexpr size_t kListed = 5;  ///< entries that lists are cut to

const PotentialBatch& law_of(const PotentialBatch& batch) { return batch; }
const PotentialBatch& law_of(const QuadratureBatch& batch) { return batch.law(); }
int64_t elements_of(const PotentialBatch& batch) { return batch.size(); }
int64_t elements_of(const QuadratureBatch& batch) { return batch.size(); }
std::vector<double> outputs_of(const PotentialBatch& batch, std::span<const Vec3> x) {
  return batch.evaluate(symbolic::Order::Gradient, x);
}
std::vector<double> outputs_of(const QuadratureBatch& batch, std::span<const Vec3> x) {
  return batch.energies(x);
}

/// Position of the first number that is not finite, -1: all are.
int64_t first_bad(std::span<const double> values) {
  const auto bad = std::ranges::find_if(values, [](double v) { return !std::isfinite(v); });
  return bad == values.end() ? -1 : bad - values.begin();
}

/// An element of a batch with numbers that are not finite; -1: none.
struct Bad {
  int64_t element = -1;
  std::string update;  ///< "internal variable 'flow'", where it is one
};

/// " of law 'maxwell'" of what has this name: a body, a skin, fibres.
std::string law_text(const Scene& scene, const std::string& owner) {
  std::string name;
  const auto take = [&](const std::string& known, const auto& part) {
    if constexpr (requires { part.law; })
      if (known == owner && part.law) name = part.law->name;
  };
  for (int32_t b = 0; b < scene.body_count(); ++b)
    scene.visit(BodyId{b}, [&](const auto& body) { take(scene.name(BodyId{b}), body); });
  for (const SkinDescription& skin : scene.skins()) take(skin.name, skin);
  for (const FibresDescription& fibres : scene.fibres()) take(fibres.name, fibres);
  return name.empty() ? "" : " of law '" + name + "'";
}

/// Name of the internal variable that has this entry of all of an element.
std::string variable_of(const Potential& law, int entry) {
  for (const ElementField& field : law.element_fields()) {
    if (field.source != ElementField::Source::Internal) continue;
    if (entry < field.width) return "internal variable '" + field.name + "'";
    entry -= field.width;
  }
  return "an internal variable";
}

template <typename Batch>
Bad bad_update(const Batch& batch, std::span<const Vec3> x) {
  const std::vector<double> values = batch.updated_internal(x);
  const int64_t bad = first_bad(values);
  if (bad < 0) return {};
  const auto each = static_cast<int64_t>(values.size()) / elements_of(batch);
  const Potential& law = law_of(batch).potential();
  return {bad / each, variable_of(law, static_cast<int>(bad % law.internal_width()))};
}

template <typename Batch>
Bad find_bad(const Batch& batch, std::span<const Vec3> x) {
  if (elements_of(batch) == 0) return {};
  const std::vector<double> outputs = outputs_of(batch, x);
  if (const int64_t bad = first_bad(outputs); bad >= 0)
    return {bad / (static_cast<int64_t>(outputs.size()) / elements_of(batch)), ""};
  return bad_update(batch, x);
}

/// The vertices of an element, and the body whose energy it is, or that of the user.
BodyVertices place_of(const Scene& scene, const Model& model, const std::string& owner,
                      const std::string& law, std::span<const int32_t> sites) {
  BodyVertices place{owner.empty() ? law : "'" + owner + "'"};
  for (const int32_t site : sites)
    for (int32_t b = 0; b < static_cast<int32_t>(model.bodies().size()); ++b) {
      const ModelBody& body = model.bodies()[b];
      if (site < body.first_site || site >= body.first_site + body.site_count) continue;
      const std::string& name = scene.name(BodyId{b});
      if (owner == name) place.body = owner_text(scene.kind(BodyId{b}), name);
      place.vertices.push_back(site - body.first_site);
    }
  return place;
}

}  // namespace

void add_not_finite(const FailedStep& step, StepEvidence& out) {
  const std::span<const Vec3> x = step.potential.site_positions();
  const auto add = [&](const auto& batch, const std::string& owner) {
    if (out.not_finite.size() >= kListed) return;
    const Bad bad = find_bad(batch, x);
    if (bad.element < 0) return;
    if (out.not_finite.empty()) out.not_finite_update = bad.update;
    if (out.not_finite.empty() && !bad.update.empty()) out.not_finite_update += law_text(step.scene, owner);
    out.not_finite.push_back(place_of(step.scene, step.model, owner, law_of(batch).potential().name(),
                                      batch.stencil(bad.element)));
  };
  for (const ModelBatch& part : step.energies.batches) add(part.batch, part.owner);
  for (const ModelQuadrature& part : step.energies.quadrature) add(part.batch, part.body);
}

void require_finite_updates(const Scene& scene, const Model& model, Energies& energies,
                            std::span<const Vec3> x, double h) {
  const auto require = [&](auto& batch, const std::string& owner) {
    if (law_of(batch).potential().internal_width() == 0 || elements_of(batch) == 0) return;
    batch.set_previous(x);
    batch.set_time(h, h);
    const Bad bad = bad_update(batch, x);
    if (bad.element < 0) return;
    const BodyVertices place =
        place_of(scene, model, owner, law_of(batch).potential().name(), batch.stencil(bad.element));
    throw InvalidArgument(
        bad.update + law_text(scene, owner) +
        " is not finite after a step from time 0 in which nothing moves, in " + place_text(place) +
        ": must be; look for divisions by zero, roots and logarithms of negative numbers in "
        "what the law returns for it, and guard them with where/select");
  };
  for (ModelBatch& part : energies.batches) require(part.batch, part.owner);
  for (ModelQuadrature& part : energies.quadrature) require(part.batch, part.body);
}

}  // namespace stark
