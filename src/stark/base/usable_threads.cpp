// How many threads can run at once. A container with a quota of two processors on a machine of 64 is given
// two.
#include <algorithm>
#include <cmath>
#include <fstream>
#include <limits>
#include <string>
#include <thread>

#include <stark/base/thread_pool.h>

#if defined(__linux__)
#include <sched.h>
#endif

namespace stark {

namespace {

constexpr double kNoQuota = std::numeric_limits<double>::infinity();

int processors_by_affinity() {
#if defined(__linux__)
  cpu_set_t set;
  if (sched_getaffinity(0, sizeof(set), &set) == 0) return CPU_COUNT(&set);
#endif
  return static_cast<int>(std::thread::hardware_concurrency());
}

/// "200000 100000": processor time in microseconds and the period for which it lasts (cpu.max of cgroup v2);
/// "max" is no number, and no quota.
double quota_in(const std::string& file) {
  double time = 0.0, period = 0.0;
  if (std::ifstream in(file); in >> time >> period && time > 0.0 && period > 0.0) return time / period;
  return kNoQuota;
}

/// Of cgroup v1, in two files; -1 is no quota.
double old_quota_in(const std::string& folder) {
  double time = 0.0, period = 0.0;
  std::ifstream quota(folder + "/cpu.cfs_quota_us"), length(folder + "/cpu.cfs_period_us");
  if (quota >> time && length >> period && time > 0.0 && period > 0.0) return time / period;
  return kNoQuota;
}

/// The smallest quota of the control group of this process and of those around it, in processors.
double processors_by_quota() {
  double quota = old_quota_in("/sys/fs/cgroup/cpu");
  std::ifstream groups("/proc/self/cgroup");
  for (std::string line; std::getline(groups, line);) {
    if (!line.starts_with("0::/")) continue;  // the others are of v1
    for (std::string group = line.substr(3); true; group.resize(group.rfind('/'))) {
      while (group.ends_with('/')) group.pop_back();
      quota = std::min(quota, quota_in("/sys/fs/cgroup" + group + "/cpu.max"));
      if (group.empty()) break;
    }
  }
  return quota;
}

}  // namespace

int usable_threads(int asked) {
  // The part of a processor counts as one: threads that share a quota rest together.
  const double quota = std::min(std::ceil(processors_by_quota()), 1e6);
  const int usable = std::max(1, std::min(processors_by_affinity(), static_cast<int>(quota)));
  return asked > 0 ? std::min(asked, usable) : usable;
}

}  // namespace stark
