// Fixed-size pool of threads with one primitive: run a function over task indices. Determinism rule of the
// library: a task writes only to its own outputs and reductions go over tasks in index order, so results do
// not depend on the number of threads.
#pragma once

#include <atomic>
#include <condition_variable>
#include <cstdint>
#include <mutex>
#include <thread>
#include <type_traits>
#include <vector>

namespace stark {

class ThreadPool {
 public:
  /// thread_count >= 1 counts the calling thread; 0 picks the number of cores.
  explicit ThreadPool(int thread_count = 1);
  ~ThreadPool();
  ThreadPool(const ThreadPool&) = delete;
  ThreadPool& operator=(const ThreadPool&) = delete;

  int thread_count() const { return static_cast<int>(workers_.size()) + 1; }

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
  void work(int thread);
  void drain(int thread);

  std::vector<std::thread> workers_;
  std::mutex mutex_;
  std::condition_variable wake_, done_;
  std::atomic<uint64_t> generation_{0};
  std::atomic<int64_t> next_task_{0};
  std::atomic<int> active_workers_{0};
  int64_t task_count_ = 0;
  Function function_ = nullptr;
  void* context_ = nullptr;
  bool stop_ = false;
  std::exception_ptr failure_;
};

}  // namespace stark
