#include <stark/base/error.h>

namespace stark::detail {

void throw_internal_error(const char* condition, const char* file, int line) {
  throw InternalError("internal error: check '" + std::string(condition) + "' failed at " + file + ":" +
                      std::to_string(line) + "; this is a bug in Stark, please report it");
}

}  // namespace stark::detail
