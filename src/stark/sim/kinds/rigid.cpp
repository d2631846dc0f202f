// What the rest of sim asks of rigid bodies (sim/body_kind.h).
#include <stark/sim/scene.h>

namespace stark {

namespace {

double mass(const Scene& scene, BodyId body) { return scene.rigid_inertia(body).mass; }

std::vector<Index3> surface(const Scene& scene, BodyId body) { return scene.rigid(body).mesh.triangles; }

}  // namespace

const BodyKindRow kRigidRow{.title = "rigid body",
                            .moved_by = MovedBy::RigidBody,
                            .can_be_filled = true,
                            .mass = mass,
                            .surface = surface};

}  // namespace stark
