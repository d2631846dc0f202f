// Laws on their linear elements: what a law asks of its parameters before it belongs to any body.
#pragma once

#include <string>

#include <stark/mechanics/constitutive_law.h>
#include <stark/mechanics/field_values.h>
#include <stark/mechanics/rod_law.h>

namespace stark {

/// Tetrahedra, triangles, segments of rods.
inline PotentialDefinition linear_element(const SolidLaw& law) { return tet4(law); }
inline PotentialDefinition linear_element(const ShellLaw& law) { return triangle3(law); }
inline PotentialDefinition linear_element(const RodLaw& law) { return rod_segment(law); }

/// Checks values against the declarations of a law, whatever their number; other names are not its business.
template <typename Law>
void check_law_values(const std::string& owner, const Law& law, const ParameterValues& values) {
  for (const ParameterDeclaration& declaration : parameters_of(linear_element(law)))
    if (const auto found = values.find(declaration.name); found != values.end())
      check_values(owner, declaration, found->second,
                   static_cast<int64_t>(found->second.values.size()) / declaration.width);
}

}  // namespace stark
