// How contact gets stiffer than its law: for another attempt at a step, and within one.
#include <stark/contact/pipeline.h>

namespace stark {

LoadMemory ContactPipeline::raised_load(std::span<const Vec3> x, std::span<const Vec3> start,
                                        const LoadMemory& before, double kinetic) {
  settle(start);
  const std::map<int64_t, double> most =
      law_.highest_factors(contacts(), active_.energies(), before, kinetic);
  settle(x);
  return law_.raised(contacts(), forces(x), most);
}

void ContactPipeline::allow_relief(double most) {
  is_relief_allowed_ = true;
  law_.relief().begin(contacts(), active_.energies(), most * weight_);
}

bool ContactPipeline::relieve(const SitePositions& x) {
  if (!is_relief_allowed_) return false;
  settle(x);
  law_.relieve(contacts(), forces(x.all));
  ++revision_;
  forget_sets();
  return true;
}

}  // namespace stark
