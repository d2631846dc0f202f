// mmap read-write, copy, mprotect read-execute. Phase: kernel building.
#include <stark/symbolic/backend/executable_memory.h>

#include <cstring>

#if defined(__linux__) || defined(__APPLE__)
#include <sys/mman.h>
#include <unistd.h>
#endif

namespace stark::symbolic {

ExecutableMemory::ExecutableMemory(std::span<const uint8_t> bytes) {
#if defined(__linux__)
  const auto page = static_cast<size_t>(sysconf(_SC_PAGESIZE));
  const size_t size = (bytes.size() + page - 1) / page * page;
  void* memory = mmap(nullptr, size, PROT_READ | PROT_WRITE, MAP_PRIVATE | MAP_ANONYMOUS, -1, 0);
  if (memory == MAP_FAILED) return;
  std::memcpy(memory, bytes.data(), bytes.size());
  // Where instructions have a cache of their own that does not see what was written.
  auto* const first = static_cast<char*>(memory);
  __builtin___clear_cache(first, first + bytes.size());
  if (mprotect(memory, size, PROT_READ | PROT_EXEC) != 0) {
    munmap(memory, size);
    return;
  }
  data_ = memory;
  size_ = size;
#else
  static_cast<void>(bytes);
#endif
}

ExecutableMemory::~ExecutableMemory() {
#if defined(__linux__)
  if (data_) munmap(data_, size_);
#endif
}

}  // namespace stark::symbolic
