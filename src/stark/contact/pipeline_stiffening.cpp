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
  law_.relief().allow(contacts(), active_.energies(), most * weight_);
}

bool ContactPipeline::relieve(const SitePositions& x) {
  if (!law_.relief().is_allowed()) return false;
  settle(x);
  if (!law_.relieve(contacts(), forces(x.all))) return false;
  ++revision_;
  forget_sets();
  return true;
}

}  // namespace stark
