// The potentials of contact and friction, compiled once for a model, in the order of StencilKind.
#include <stark/contact/pipeline.h>

namespace stark {

namespace models {
PotentialDefinition barrier_point_point();
PotentialDefinition barrier_point_edge();
PotentialDefinition barrier_point_triangle();
PotentialDefinition barrier_edge_edge();
PotentialDefinition barrier_mollified_point_point();
PotentialDefinition barrier_mollified_point_edge();
PotentialDefinition barrier_mollified_edge_edge();
PotentialDefinition friction_2();
PotentialDefinition friction_3();
PotentialDefinition friction_4();
PotentialDefinition friction_5();
PotentialDefinition friction_6();
PotentialDefinition anisotropic_friction_2();
PotentialDefinition anisotropic_friction_3();
PotentialDefinition anisotropic_friction_4();
PotentialDefinition anisotropic_friction_5();
PotentialDefinition anisotropic_friction_6();
PotentialDefinition restitution();
}  // namespace models

ContactPotentials compile_contact_potentials(symbolic::Backend backend, bool anisotropic, bool restitution) {
  const auto compile = [&](const PotentialDefinition& definition) {
    return std::make_shared<const Potential>(definition, backend);
  };
  ContactPotentials potentials{
      .barriers = {compile(models::barrier_point_point()), compile(models::barrier_point_edge()),
                   compile(models::barrier_point_triangle()), compile(models::barrier_edge_edge()),
                   compile(models::barrier_mollified_point_point()),
                   compile(models::barrier_mollified_point_edge()),
                   compile(models::barrier_mollified_edge_edge())},
      .friction = {.isotropic = {compile(models::friction_2()), compile(models::friction_3()),
                                 compile(models::friction_4()), compile(models::friction_5()),
                                 compile(models::friction_6())}}};
  if (anisotropic)
    potentials.friction.anisotropic = {
        compile(models::anisotropic_friction_2()), compile(models::anisotropic_friction_3()),
        compile(models::anisotropic_friction_4()), compile(models::anisotropic_friction_5()),
        compile(models::anisotropic_friction_6())};
  if (restitution) potentials.restitution = compile(models::restitution());
  return potentials;
}

}  // namespace stark
