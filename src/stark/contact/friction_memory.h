// What friction remembers of the pairs in contact from one step to the next: how far the bristles between the
// surfaces are bent, and the normal force. Part of the State, so rewinding and resuming are exact. [theory
// eq. 20a]
#pragma once

#include <span>
#include <utility>
#include <vector>

#include <stark/collision/candidates.h>
#include <stark/contact/contact_set.h>

namespace stark {

/// Entries are sorted by pair, without doubles.
struct FrictionMemory {
  std::vector<int64_t> pair;     ///< pack(key)
  std::vector<Vec3> deflection;  ///< of the side of key.first against that of key.second [m]
  std::vector<double> force;     ///< normal force [N]

  void reserve(size_t count);
  void append(const PairKey& key, const Vec3& pair_deflection, double normal_force);
  /// Index of a pair, -1 when nothing is known of it.
  int64_t find(const PairKey& key) const;
  /// Indices of the pairs of the same kind and first primitive, from one to before the other.
  std::pair<int64_t, int64_t> of_first(const PairKey& key) const;
};

/// Order-preserving number of a pair: two bits for the list and thirty for each primitive.
int64_t pack(const PairKey& key);
PairKey unpack(int64_t code);

/// Angle by which the material of a pair (its triangle or an edge) turns about the unit normal while sites
/// move from x0 to x1 [rad]; 0 for pairs of points and for edges along the normal, which show no turning.
double spin(const SurfaceMesh& mesh, const PairKey& key, const Vec3& normal, std::span<const Vec3> x0,
            std::span<const Vec3> x1);

/// -1 when the contact's side A belongs to key.second, as the stencils of some pairs of edges have it;
/// else 1.
double orientation(const SurfaceMesh& mesh, const Contact& contact);

}  // namespace stark
