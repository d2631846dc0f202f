// Vectors whose storage starts on a cache line, for kernels that load whole SIMD registers.
#pragma once

#include <cstddef>
#include <cstdint>
#include <memory>
#include <new>
#include <vector>

namespace stark {

inline constexpr std::size_t kCacheLine = 64;  // bytes

/// Allocator with cache-line alignment.
template <typename T>
struct AlignedAllocator {
  using value_type = T;

  AlignedAllocator() = default;
  template <typename U>
  constexpr AlignedAllocator(const AlignedAllocator<U>&) {}

  T* allocate(std::size_t count) {
    return static_cast<T*>(::operator new(count * sizeof(T), std::align_val_t{kCacheLine}));
  }
  void deallocate(T* pointer, std::size_t) { ::operator delete(pointer, std::align_val_t{kCacheLine}); }

  template <typename U>
  bool operator==(const AlignedAllocator<U>&) const {
    return true;
  }
};

template <typename T>
using AlignedVector = std::vector<T, AlignedAllocator<T>>;

/// Aligned storage that is not initialised, and loses its contents when it grows.
template <typename T>
class ScratchBuffer {
 public:
  /// Room for `size` values. Grows with a margin, so that slowly growing demands rarely allocate.
  T* reserve(int64_t size) {
    if (size > capacity_) {
      capacity_ = size + size / 4 + 1024;
      data_.reset();
      data_.reset(AlignedAllocator<T>().allocate(static_cast<size_t>(capacity_)));
    }
    return data_.get();
  }
  T* data() const { return data_.get(); }

 private:
  struct Free {
    void operator()(T* p) const { AlignedAllocator<T>().deallocate(p, 0); }
  };
  std::unique_ptr<T[], Free> data_;
  int64_t capacity_ = 0;
};

}  // namespace stark
