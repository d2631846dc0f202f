// What a step reports, for Python.
#pragma once

#include <nanobind/nanobind.h>

namespace stark::bindings {

void bind_report(nanobind::module_& m);

}  // namespace stark::bindings
