// From the description of a cloth, a solid, a rod or fibres to its elastic energy and the values of its
// parameters: the law that it was given or the default one, values from its fields, else from its material.
// Phase: model building.
#pragma once

#include <string_view>

#include <stark/mechanics/field_values.h>
#include <stark/sim/scene/scene.h>

namespace stark {

/// Potential of the elements of a body, elastic and viscous part in one, with all values that it needs.
struct ElasticEnergy {
  PotentialDefinition definition;
  ParameterValues values;
};

ElasticEnergy elastic_energy(const SolidDescription& solid);
ElasticEnergy elastic_energy(const ClothDescription& cloth);
ElasticEnergy elastic_energy(const RodDescription& rod);
ElasticEnergy elastic_energy(const FibresDescription& fibres);

/// Parameters of the law of a body alone, without its rest state.
std::vector<ParameterDeclaration> law_parameters(const SolidDescription& solid);
std::vector<ParameterDeclaration> law_parameters(const ClothDescription& cloth);
std::vector<ParameterDeclaration> law_parameters(const RodDescription& rod);

/// Throws InvalidArgument when a parameter of the law has no value, a field is of no use to the body, or its
/// values are too few, too many, not finite or out of range.
void check_fields(std::string_view owner, const SolidDescription& solid);
void check_fields(std::string_view owner, const ClothDescription& cloth);
void check_fields(std::string_view owner, const RodDescription& rod);
void check_fields(std::string_view owner, const FibresDescription& fibres);

/// Young's modulus of the elements [Pa], the smallest; infinity for laws without.
double smallest_modulus(const ElasticEnergy& energy);

/// Density of an element [kg/m^3], of cloth [kg/m^2].
double element_density(const SolidDescription& solid, size_t element);
double element_density(const ClothDescription& cloth, size_t element);
double element_density(const RodDescription& rod, size_t element);
double element_density(const FibresDescription& fibres, size_t element);

/// Of a triangle of cloth, [J] of its hinges and [N m] of a plate.
double bending_stiffness(const ClothDescription& cloth, size_t triangle);
double flexural_rigidity(const ClothDescription& cloth, size_t triangle);
/// Gives the material the largest values of fields of both, so that it says whether a sheet bends at all, and
/// how.
void keep_largest_bending(ShellMaterial& material, const ParameterValues& fields);

}  // namespace stark
