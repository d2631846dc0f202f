// Bindings of the diagnosis of a step that failed.
#pragma once

#include <nanobind/nanobind.h>

#include <stark/sim/diagnosis.h>

namespace stark::bindings {

/// Adds the class Diagnosis to a module.
void bind_diagnosis(nanobind::module_& m);
/// All of a diagnosis as dictionaries, lists, numbers and texts.
nanobind::dict diagnosis_dict(const Diagnosis& diagnosis);

}  // namespace stark::bindings
