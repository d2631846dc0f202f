#include <stark/base/thread_pool.h>

#include <algorithm>
#include <atomic>
#include <chrono>
#include <condition_variable>
#include <exception>
#include <mutex>
#include <thread>
#include <vector>

#if defined(__unix__) || defined(__APPLE__)
#include <pthread.h>
#endif

namespace stark {

namespace {

void pause_briefly() {
#if defined(__x86_64__)
  __builtin_ia32_pause();
#elif defined(__aarch64__)
  __asm__ volatile("yield");
#endif
}

/// Waiting awake before going to sleep. Where waits are short it costs less than to wake a thread. Where
/// other processes want the processor, perhaps that of the thread waited for, it costs them and us: so it is
/// tried for long only while waits are short.
class Spin {
 public:
  template <typename Condition, typename Sleep>
  void wait(const Condition& is_over, const Sleep& sleep) {
    const auto begin = Clock::now();
    for (int k = 0; k < count_ && !is_over(); ++k) pause_briefly();
    sleep();
    const bool was_short = Clock::now() - begin < kShort;
    count_ = was_short ? std::min(2 * count_, kMost) : std::max(count_ / 2, kLeast);
  }

 private:
  using Clock = std::chrono::steady_clock;
  static constexpr std::chrono::microseconds kShort{50};
  static constexpr int kLeast = 100, kMost = 4000;
  int count_ = kMost;
};

std::atomic<uint64_t> fork_depth{0};

/// Tells a process from the one that it was forked from, at the price of a load.
uint64_t this_process() {
#if defined(__unix__) || defined(__APPLE__)
  [[maybe_unused]] static const int registered =
      pthread_atfork(nullptr, nullptr, [] { fork_depth.fetch_add(1); });
#endif
  return fork_depth.load(std::memory_order_relaxed);
}

}  // namespace

class ThreadPool::Workers {
 public:
  explicit Workers(int count) {
    for (int thread = 1; thread <= count; ++thread) threads_.emplace_back([this, thread] { work(thread); });
  }

  ~Workers() {
    {
      std::lock_guard lock(mutex_);
      stop_ = true;
      generation_.fetch_add(1);
    }
    wake_.notify_all();
    for (std::thread& thread : threads_) thread.join();
  }

  void run(int64_t task_count, Function function, void* context) {
    {
      std::lock_guard lock(mutex_);
      task_count_ = task_count;
      function_ = function;
      context_ = context;
      failure_ = nullptr;
      next_task_.store(0);
      active_.store(static_cast<int>(threads_.size()));
      generation_.fetch_add(1);
    }
    wake_.notify_all();
    drain(0);
    const auto is_done = [this] { return active_.load() == 0; };
    spin_.wait(is_done, [&] {
      std::unique_lock lock(mutex_);
      done_.wait(lock, is_done);
    });
    if (failure_) std::rethrow_exception(failure_);
  }

 private:
  void drain(int thread) {
    for (int64_t task; (task = next_task_.fetch_add(1)) < task_count_;) {
      try {
        function_(context_, task, thread);
      } catch (...) {
        std::lock_guard lock(mutex_);
        if (!failure_) failure_ = std::current_exception();
      }
    }
  }

  void work(int thread) {
    uint64_t seen = 0;
    Spin spin;
    while (true) {
      const auto is_called = [&] { return generation_.load() != seen; };
      spin.wait(is_called, [&] {
        std::unique_lock lock(mutex_);
        wake_.wait(lock, is_called);
        seen = generation_.load();
      });
      if (stop_) return;
      drain(thread);
      if (active_.fetch_sub(1) == 1) {
        std::lock_guard lock(mutex_);
        done_.notify_one();
      }
    }
  }

  std::vector<std::thread> threads_;
  Spin spin_;  ///< of the thread that calls run()
  std::mutex mutex_;
  std::condition_variable wake_, done_;
  std::atomic<uint64_t> generation_{0};
  std::atomic<int64_t> next_task_{0};
  std::atomic<int> active_{0};
  int64_t task_count_ = 0;
  Function function_ = nullptr;
  void* context_ = nullptr;
  bool stop_ = false;
  std::exception_ptr failure_;
};

ThreadPool::ThreadPool(int thread_count) : thread_count_(std::max(thread_count, 1)) { start_workers(); }

ThreadPool::~ThreadPool() {
  // Threads of the parent cannot be joined, and their locks may be held for ever.
  if (process_ != this_process()) static_cast<void>(workers_.release());
}

void ThreadPool::start_workers() {
  static_cast<void>(workers_.release());  // of the parent, see above; none at first
  process_ = this_process();
  if (thread_count_ > 1) workers_ = std::make_unique<Workers>(thread_count_ - 1);
}

void ThreadPool::run(int64_t task_count, Function function, void* context) {
  if (thread_count_ <= 1 || task_count <= 1) {
    for (int64_t task = 0; task < task_count; ++task) function(context, task, 0);
    return;
  }
  if (process_ != this_process()) start_workers();
  workers_->run(task_count, function, context);
}

}  // namespace stark
