// Values of the parameters of a potential as users give them: one for all elements of a body or one for each.
// Declarations come from the formula itself, so a parameter is described once, where it is used. Phase: model
// building.
#pragma once

#include <map>
#include <set>
#include <span>
#include <string>
#include <string_view>
#include <vector>

#include <stark/mechanics/formula.h>
#include <stark/mechanics/potential_batch.h>

namespace stark {

/// `width` numbers, or `width` numbers for each element, element by element.
struct FieldValues {
  std::vector<double> values{};
  bool per_element = false;
  bool operator==(const FieldValues&) const = default;
};
using ParameterValues = std::map<std::string, FieldValues>;

/// What a potential asks for under a name.
struct ParameterDeclaration {
  std::string name, unit, doc;
  int width = 1;
  FieldRule rule = any_number();
  bool is_direction = false;
  bool is_data = false;  ///< must be given for each element
};

/// Parameters and data of a potential, each in the order of their first use; time_step and time are not among
/// them. Runs the formula.
std::vector<ParameterDeclaration> parameters_of(const PotentialDefinition& definition);
std::vector<ParameterDeclaration> parameters_of(const Formula& formula);

/// Checks values against a declaration: as many as needed, finite, in range. Throws InvalidArgument:
/// "solid 'cube': c10[3] = -1 Pa: must be > 0 and finite; ...".
void check_values(std::string_view owner, const ParameterDeclaration& declaration, const FieldValues& values,
                  int64_t element_count);

/// Names of the parameters that have a value for each element.
std::set<std::string> per_element_names(const ParameterValues& values);

/// Writes checked values into a batch whose potential was compiled with per_element_names(values); names that
/// the potential does not know are skipped.
void set_values(PotentialBatch& batch, const ParameterValues& values);

}  // namespace stark
