// Exceptions of the library. Numerics never throw: a failed step is a value (sim/report.h). Exceptions are
// for bad input, found before any work is done, and for bugs of the library itself.
#pragma once

#include <stdexcept>
#include <string>

namespace stark {

/// Base of every exception that the library throws.
class Error : public std::runtime_error {
 public:
  using std::runtime_error::runtime_error;
};

/// A value handed to the library breaks a rule. The message names object, value with unit, rule and remedy.
class InvalidArgument : public Error {
 public:
  using Error::Error;
};

/// An unknown setting, or a setting outside its range.
class InvalidSetting : public InvalidArgument {
 public:
  using InvalidArgument::InvalidArgument;
};

/// A mesh that cannot be simulated: indices out of range, degenerate or inverted elements, non-finite
/// vertices.
class InvalidMesh : public InvalidArgument {
 public:
  using InvalidArgument::InvalidArgument;
};

/// Two surfaces intersect, or one contains the other, in the initial configuration.
class InitialIntersection : public InvalidArgument {
 public:
  using InvalidArgument::InvalidArgument;
};

/// A formula that cannot be traced or compiled: control flow that depends on its values, wrong shapes.
class TraceError : public InvalidArgument {
 public:
  using InvalidArgument::InvalidArgument;
};

/// A defect of the library itself, never of its input.
class InternalError : public Error {
 public:
  using Error::Error;
};

namespace detail {
[[noreturn]] void throw_internal_error(const char* condition, const char* file, int line);
}  // namespace detail

}  // namespace stark

/// Always-on check of an invariant of the library; a failure is a bug and throws InternalError.
#define STARK_CHECK(condition) \
  ((condition) ? void(0) : ::stark::detail::throw_internal_error(#condition, __FILE__, __LINE__))
