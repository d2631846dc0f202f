// Memory for machine code that is never writable and executable at once. Phase: kernel building.
#pragma once

#include <cstddef>
#include <cstdint>
#include <span>

namespace stark::symbolic {

/// Read-only, executable copy of some bytes; empty where the system refuses it.
class ExecutableMemory {
 public:
  ExecutableMemory() = default;
  explicit ExecutableMemory(std::span<const uint8_t> bytes);
  ~ExecutableMemory();
  ExecutableMemory(const ExecutableMemory&) = delete;
  ExecutableMemory& operator=(const ExecutableMemory&) = delete;

  const void* data() const { return data_; }

 private:
  void* data_ = nullptr;
  size_t size_ = 0;
};

}  // namespace stark::symbolic
