// The extension module stark._core: checks the processor, makes the exception types, calls one function per
// domain. This file is compiled for baseline x86-64 (see python/CMakeLists.txt); everything else needs AVX2
// and FMA.
#include <nanobind/stl/string.h>

#include <cstdlib>

#include <stark/base/error.h>

#include "domains.h"
#include "without_gil.h"

namespace nb = nanobind;
using namespace stark::bindings;

namespace {

/// Types live as long as the process. Translators of later ones are asked first: bases come before what is
/// derived from them.
template <typename Exception>
nb::object add_exception(nb::module_& m, const char* name, const char* doc, nb::handle bases) {
  nb::object type = nb::exception<Exception>(m, name, bases);
  type.attr("__doc__") = doc;
  // Users know them as stark.Error; the stub generator loads this file as plain _core and needs them to
  // belong to it.
  if (nb::cast<std::string>(m.attr("__name__")) == "stark._core") type.attr("__module__") = "stark";
  return type;
}

void bind_exceptions(nb::module_& m) {
  const nb::object error =
      add_exception<stark::Error>(m, "Error", "Base of every exception that Stark raises.", PyExc_Exception);
  const nb::object argument = add_exception<stark::InvalidArgument>(
      m, "InvalidArgument", "A value handed to Stark breaks a rule; the message names the remedy.",
      nb::make_tuple(error, nb::handle(PyExc_ValueError)));
  add_exception<stark::InvalidSetting>(m, "InvalidSetting", "An unknown setting, or one outside its range.",
                                       argument);
  add_exception<stark::InvalidMesh>(
      m, "InvalidMesh", "A mesh that cannot be simulated: bad indices, degenerate or inverted elements.",
      argument);
  add_exception<stark::InitialIntersection>(m, "InitialIntersection",
                                            "Surfaces intersect in the initial configuration.", argument);
  add_exception<stark::TraceError>(
      m, "TraceError",
      "A formula that cannot be recorded or compiled: control flow that depends on its values, wrong shapes.",
      argument);
  add_exception<stark::InternalError>(m, "InternalError", "A defect of Stark itself, never of its input.",
                                      error);
}

void require_supported_processor() {
#if defined(__x86_64__)
  __builtin_cpu_init();
  if (!__builtin_cpu_supports("avx2") || !__builtin_cpu_supports("fma"))
    throw nb::import_error(
        "Stark needs a processor with AVX2 and FMA (x86-64-v3: Intel Haswell 2013, AMD Zen 2017 or newer)");
#endif
}

}  // namespace

NB_MODULE(_core, m) {
  require_supported_processor();
  m.doc() = "Compiled core of Stark; the public interface is the package stark.";
  m.attr("__version__") = STARK_VERSION;
  bind_exceptions(m);
  wait_at_exit();
  // Debuggers and test runners keep frames alive: for those to know who look for leaks of these bindings.
  nb::set_leak_warnings(std::getenv("STARK_LEAK_WARNINGS") != nullptr);
  bind_geometry(m);
  bind_definitions(m);
  bind_settings(m);
  bind_scene(m);
  bind_solid_mesh(m);
  bind_simulation(m);
  bind_io(m);
  bind_formulas(m);
  bind_symbolic(m);
}
