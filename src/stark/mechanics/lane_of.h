// Numbers of elements in consecutive blocks of lanes, as kernels read and write them.
#pragma once

#include <cstdint>

#include <stark/symbolic/kernel.h>

namespace stark {

/// First number of a lane, counted over all blocks of `rows` numbers a lane; number k is at [k * kLanes].
template <typename Number>
Number* lane_of(Number* blocks, int rows, int64_t lane) {
  return blocks + lane / symbolic::kLanes * rows * symbolic::kLanes + lane % symbolic::kLanes;
}

}  // namespace stark
