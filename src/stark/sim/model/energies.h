// The energies of a scene as batches. Stencils, rest shapes and parameters are those of the scene; what a
// step starts from, its length and live values are written before it is taken.
#pragma once

#include <string>
#include <vector>

#include <stark/mechanics/constraint_set.h>
#include <stark/mechanics/potential_batch.h>
#include <stark/mechanics/quadrature_batch.h>

namespace stark {

/// A batch and what it means to the time step and the energy ledger.
struct ModelBatch {
  enum class Role : uint8_t { Inertia, RotationalInertia, Elastic };
  Role role = Role::Elastic;
  std::string owner;  ///< name of the body, the layer or the user's energy, empty for batches of all bodies
  PotentialBatch batch;
  /// What moves each element. Inertia: a point, or -1 - body; RotationalInertia: 3 body + axis.
  std::vector<int32_t> subject;
  /// Whether its elements are the triangles or tetrahedra of the owner, in their order, and what it
  /// stretches.
  bool carries_stress = false;

  bool is_inertia() const { return role != Role::Elastic; }
};

/// Elements with quadrature points of one body.
struct ModelQuadrature {
  std::string body;
  QuadratureBatch batch;
};

inline const Potential& potential_of(const PotentialBatch& batch) { return batch.potential(); }
inline const Potential& potential_of(const QuadratureBatch& batch) { return batch.law().potential(); }

struct Energies {
  std::vector<ModelBatch> batches;
  std::vector<ModelQuadrature> quadrature;
  ConstraintSet constraints{{}};  ///< of joints, actuators and attachments; empty without any

  /// All but those of quadrature points.
  std::vector<PotentialBatch*> all_batches();
};

}  // namespace stark
