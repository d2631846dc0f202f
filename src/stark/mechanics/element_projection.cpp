// See element_projection.h.
#include <stark/mechanics/element_projection.h>

#include <array>
#include <bit>

#include <stark/base/psd.h>

namespace stark {

using symbolic::kLanes;

namespace {

static_assert(kLanes == kPsdLanes);
constexpr int kMaxEntries = kPsdMaxSize * (kPsdMaxSize + 1) / 2;
constexpr uint32_t kAll = (1u << kLanes) - 1;

/// Matrices from several blocks in the lanes of one: a projection costs the same for one lane as for all, and
/// the result of a lane does not depend on its neighbours.
class ProjectionPack {
 public:
  ProjectionPack(int n, bool reduced) : n_(n), entries_(n * (n + 1) / 2), reduced_(reduced) {}

  void add(double* lane) {
    lanes_[count_] = lane;
    for (int k = 0; k < entries_; ++k) packed_[kLanes * k + count_] = lane[kLanes * k];
    if (++count_ == kLanes) flush();
  }

  void flush() {
    if (count_ == 0) return;
    for (int k = 0; k < entries_; ++k)
      for (int l = count_; l < kLanes; ++l) packed_[kLanes * k + l] = 0.0;
    psd_project(packed_.data(), n_, (1u << count_) - 1, reduced_);
    for (int l = 0; l < count_; ++l)
      for (int k = 0; k < entries_; ++k) lanes_[l][kLanes * k] = packed_[kLanes * k + l];
    count_ = 0;
  }

 private:
  int n_, entries_;
  bool reduced_;
  int count_ = 0;
  std::array<double*, kLanes> lanes_{};
  std::array<double, kMaxEntries * kLanes> packed_;
};

}  // namespace

int64_t project_blocks(const Potential& potential, int64_t block_count, double* out) {
  const int n = potential.kernel().unknown_count();
  const int outputs = potential.kernel().output_count(symbolic::Order::Hessian);
  const bool reduced =
      potential.is_translation_invariant() && n >= 6 && n <= kPsdMaxReduced;  // fewer dimensions, same result
  return project_blocks(n, 1 + n, outputs, reduced, block_count, out);
}

int64_t project_blocks(int n, int first, int outputs, bool reduced, int64_t block_count, double* out) {
  ProjectionPack pack(n, reduced);
  int64_t count = 0;
  for (int64_t block = 0; block < block_count; ++block) {
    double* upper = out + (block * outputs + first) * kLanes;
    const uint32_t mask = psd_test(upper, n);
    count += std::popcount(mask);
    if (mask == kAll) {
      psd_project(upper, n, mask, reduced);
      continue;
    }
    for (int l = 0; l < kLanes; ++l)
      if ((mask >> l & 1u) != 0) pack.add(upper + l);
  }
  pack.flush();
  return count;
}

}  // namespace stark
