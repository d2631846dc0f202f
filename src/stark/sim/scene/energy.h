// An energy of the user's own in a scene: a formula, the points it acts on, the values of its parameters.
// Built-in energies are made of the same parts by sim/model; there is no other way.
#pragma once

#include <string>
#include <vector>

#include <stark/mechanics/field_values.h>
#include <stark/mechanics/potential.h>
#include <stark/sim/scene/point_set.h>

namespace stark {

struct EnergyDescription {
  std::string name{};  ///< unique among the energies of the scene; empty: the potential's, numbered
  PotentialDefinition potential{};
  /// One set for each point of the potential. Sets of more than one point have the same size, the number of
  /// elements; a set of one point serves all elements.
  std::vector<PointSet> points{};
  ParameterValues values{};  ///< of all data and parameters of the potential

  int64_t element_count() const;
};

}  // namespace stark
