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

/// One job at a time. Workers enter it when they are awake, and the caller waits for those that have: one
/// that sleeps, or that another process keeps from running, delays nothing.
class ThreadPool::Workers {
 public:
  explicit Workers(int count) {
    for (int thread = 1; thread <= count; ++thread) threads_.emplace_back([this, thread] { work(thread); });
  }

  ~Workers() {
    {
      std::lock_guard lock(mutex_);
      stop_.store(true);
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
      job_.fetch_add(kNumber + kOpen);
    }
    wake_.notify_all();
    drain(0);
    job_.fetch_sub(kOpen);
    const auto is_done = [this] { return (job_.load() & kInside) == 0; };
    spin_.wait(is_done, [&] {
      std::unique_lock lock(mutex_);
      done_.wait(lock, is_done);
    });
    if (failure_) std::rethrow_exception(failure_);
  }

 private:
  // Of job_: how many workers are inside, whether others may enter, and its number.
  static constexpr uint64_t kInside = (uint64_t{1} << 16) - 1, kOpen = uint64_t{1} << 16,
                            kNumber = uint64_t{1} << 17;
  static uint64_t number(uint64_t job) { return job / kNumber; }
  static bool is_new(uint64_t job, uint64_t last) { return (job & kOpen) != 0 && number(job) != last; }

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

  /// Enters a job that is open and not the last one.
  bool enter(uint64_t& last) {
    uint64_t job = job_.load();
    while (is_new(job, last)) {
      if (!job_.compare_exchange_weak(job, job + 1)) continue;
      last = number(job);
      return true;
    }
    return false;
  }

  void leave() {
    const uint64_t before = job_.fetch_sub(1);
    if ((before & kOpen) != 0 || (before & kInside) != 1) return;
    std::lock_guard lock(mutex_);
    done_.notify_one();
  }

  void work(int thread) {
    uint64_t last = 0;
    Spin spin;
    while (true) {
      const auto is_called = [&] { return stop_.load() || is_new(job_.load(), last); };
      spin.wait(is_called, [&] {
        std::unique_lock lock(mutex_);
        wake_.wait(lock, is_called);
      });
      if (stop_.load()) return;
      if (!enter(last)) continue;
      drain(thread);
      leave();
    }
  }

  std::vector<std::thread> threads_;
  Spin spin_;  ///< of the thread that calls run()
  std::mutex mutex_;
  std::condition_variable wake_, done_;
  std::atomic<uint64_t> job_{0};
  std::atomic<int64_t> next_task_{0};
  int64_t task_count_ = 0;
  Function function_ = nullptr;
  void* context_ = nullptr;
  std::atomic<bool> stop_{false};
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
