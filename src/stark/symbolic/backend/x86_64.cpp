#include <stark/symbolic/backend/executable.h>
namespace stark::symbolic {
std::unique_ptr<Executable> make_machine_code(const Program&, Backend) { return nullptr; }
}  // namespace stark::symbolic
