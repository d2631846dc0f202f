// The extension module stark._core: checks the processor, makes the exception types, calls one function per
// domain. This file is compiled for baseline x86-64 (see python/CMakeLists.txt); everything else needs AVX2
// and FMA.
#include <nanobind/nanobind.h>
#include <nanobind/stl/string.h>

#include <cstdlib>
#include <exception>
#include <string>

#include <stark/base/error.h>

#include "domains.h"
#include "without_gil.h"

namespace nb = nanobind;

namespace {

/// Exception types of the module, index-aligned with the catch clauses of translate(). They live as long as
/// the process.
struct ExceptionTypes {
  PyObject* error = nullptr;
  PyObject* invalid_argument = nullptr;
  PyObject* invalid_setting = nullptr;
  PyObject* invalid_mesh = nullptr;
  PyObject* initial_intersection = nullptr;
  PyObject* trace_error = nullptr;
  PyObject* internal_error = nullptr;
};

PyObject* add_exception(nb::module_& m, const char* name, const char* doc, nb::handle bases) {
  // Users know them as stark.Error; the stub generator loads this file as plain _core and needs them to
  // belong to it.
  const std::string module = nb::cast<std::string>(m.attr("__name__"));
  const std::string qualified = (module == "stark._core" ? "stark" : module) + "." + name;
  PyObject* type = PyErr_NewExceptionWithDoc(qualified.c_str(), doc, bases.ptr(), nullptr);
  if (type == nullptr) throw nb::python_error();
  m.attr(name) = nb::handle(type);
  return type;
}

/// Most derived first; anything else falls through to nanobind's own translators.
void translate(const std::exception_ptr& exception, void* payload) {
  const ExceptionTypes& types = *static_cast<const ExceptionTypes*>(payload);
  try {
    std::rethrow_exception(exception);
  } catch (const stark::InitialIntersection& e) {
    PyErr_SetString(types.initial_intersection, e.what());
  } catch (const stark::TraceError& e) {
    PyErr_SetString(types.trace_error, e.what());
  } catch (const stark::InvalidMesh& e) {
    PyErr_SetString(types.invalid_mesh, e.what());
  } catch (const stark::InvalidSetting& e) {
    PyErr_SetString(types.invalid_setting, e.what());
  } catch (const stark::InvalidArgument& e) {
    PyErr_SetString(types.invalid_argument, e.what());
  } catch (const stark::InternalError& e) {
    PyErr_SetString(types.internal_error, e.what());
  } catch (const stark::Error& e) {
    PyErr_SetString(types.error, e.what());
  }
}

void bind_exceptions(nb::module_& m) {
  static ExceptionTypes types;
  types.error = add_exception(m, "Error", "Base of every exception that Stark raises.", PyExc_Exception);
  types.invalid_argument = add_exception(
      m, "InvalidArgument", "A value handed to Stark breaks a rule; the message names the remedy.",
      nb::make_tuple(nb::handle(types.error), nb::handle(PyExc_ValueError)));
  types.invalid_setting = add_exception(m, "InvalidSetting", "An unknown setting, or one outside its range.",
                                        types.invalid_argument);
  types.invalid_mesh = add_exception(
      m, "InvalidMesh", "A mesh that cannot be simulated: bad indices, degenerate or inverted elements.",
      types.invalid_argument);
  types.initial_intersection = add_exception(
      m, "InitialIntersection", "Surfaces intersect in the initial configuration.", types.invalid_argument);
  types.trace_error = add_exception(
      m, "TraceError",
      "A formula that cannot be recorded or compiled: control flow that depends on its values, wrong shapes.",
      types.invalid_argument);
  types.internal_error =
      add_exception(m, "InternalError", "A defect of Stark itself, never of its input.", types.error);
  nb::register_exception_translator(translate, &types);
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
  stark::bindings::wait_at_exit();
  // What an interpreter leaves alive when it ends, frames in a debugger or a test runner, is for those to
  // know who look for it in these bindings.
  nb::set_leak_warnings(std::getenv("STARK_LEAK_WARNINGS") != nullptr);
  bind_geometry(m);
  bind_laws(m);
  bind_settings(m);
  bind_scene(m);
  bind_solid_mesh(m);
  bind_simulation(m);
  bind_io(m);
  bind_potentials(m);
  bind_formulas(m);
  bind_definitions(m);
  bind_contacts(m);
  bind_symbolic(m);
}
