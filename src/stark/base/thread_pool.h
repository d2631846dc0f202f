// Fixed-size pool of threads with one primitive: run a function over task indices. Determinism rule of the
// library: a task writes only to its own outputs and reductions go over tasks in index order, so results do
// not depend on the number of threads. A fork copies none of the workers: the child starts its own.
#pragma once

#include <cstdint>
#include <memory>
#include <type_traits>

namespace stark {

class ThreadPool {
 public:
  /// thread_count counts the calling thread. More than usable_threads() only wait for each other.
  explicit ThreadPool(int thread_count = 1);
  ~ThreadPool();
  ThreadPool(const ThreadPool&) = delete;
  ThreadPool& operator=(const ThreadPool&) = delete;

  int thread_count() const { return thread_count_; }

  /// Calls body(task, thread) for every task in [0, task_count), in any order, on all threads; thread is in
  /// [0, thread_count()). Returns when all are done. Exceptions of the body are rethrown here (the first by
  /// time).
  template <typename Body>
  void for_each_task(int64_t task_count, Body&& body) {
    run(
        task_count,
        [](void* context, int64_t task, int thread) {
          (*static_cast<std::remove_reference_t<Body>*>(context))(task, thread);
        },
        const_cast<void*>(static_cast<const void*>(&body)));
  }

  /// Calls body(begin, end) on consecutive ranges of [0, count) of `grain` items; the split does not depend
  /// on the number of threads.
  template <typename Body>
  void for_each_range(int64_t count, int64_t grain, Body&& body) {
    const int64_t tasks = (count + grain - 1) / grain;
    for_each_task(tasks, [&](int64_t task, int) {
      const int64_t begin = task * grain, end = begin + grain < count ? begin + grain : count;
      body(begin, end);
    });
  }

 private:
  using Function = void (*)(void*, int64_t, int);
  void run(int64_t task_count, Function function, void* context);
  void start_workers();

  class Workers;
  int thread_count_;
  uint64_t process_ = 0;  ///< in which the workers run
  std::unique_ptr<Workers> workers_;
};

/// Number of threads that can run at once: `asked` (0: no limit), but at most one for each processor that the
/// process may use, by its affinity and by the quota of its control group.
int usable_threads(int asked);

}  // namespace stark
