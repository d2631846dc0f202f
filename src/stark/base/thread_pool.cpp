#include <stark/base/thread_pool.h>

#include <exception>

namespace stark {

namespace {
// A region that follows within about 50 us finds the workers still spinning: waking a sleeping thread costs
// as much. Later they sleep and cost nothing.
constexpr int kSpinCount = 4000;

void pause_briefly() {
#if defined(__x86_64__)
  __builtin_ia32_pause();
#endif
}
}  // namespace

ThreadPool::ThreadPool(int thread_count) {
  if (thread_count <= 0) thread_count = static_cast<int>(std::thread::hardware_concurrency());
  for (int thread = 1; thread < thread_count; ++thread)
    workers_.emplace_back([this, thread] { work(thread); });
}

ThreadPool::~ThreadPool() {
  {
    std::lock_guard lock(mutex_);
    stop_ = true;
    generation_.fetch_add(1);
  }
  wake_.notify_all();
  for (std::thread& worker : workers_) worker.join();
}

void ThreadPool::run(int64_t task_count, Function function, void* context) {
  if (workers_.empty() || task_count <= 1) {
    for (int64_t task = 0; task < task_count; ++task) function(context, task, 0);
    return;
  }
  {
    std::lock_guard lock(mutex_);
    task_count_ = task_count;
    function_ = function;
    context_ = context;
    failure_ = nullptr;
    next_task_.store(0);
    active_workers_.store(static_cast<int>(workers_.size()));
    generation_.fetch_add(1);
  }
  wake_.notify_all();
  drain(0);
  for (int spin = 0; spin < kSpinCount && active_workers_.load() > 0; ++spin) pause_briefly();
  std::unique_lock lock(mutex_);
  done_.wait(lock, [this] { return active_workers_.load() == 0; });
  if (failure_) std::rethrow_exception(failure_);
}

void ThreadPool::drain(int thread) {
  for (int64_t task; (task = next_task_.fetch_add(1)) < task_count_;) {
    try {
      function_(context_, task, thread);
    } catch (...) {
      std::lock_guard lock(mutex_);
      if (!failure_) failure_ = std::current_exception();
    }
  }
}

void ThreadPool::work(int thread) {
  uint64_t seen = 0;
  while (true) {
    for (int spin = 0; spin < kSpinCount && generation_.load() == seen; ++spin) pause_briefly();
    {
      std::unique_lock lock(mutex_);
      wake_.wait(lock, [&] { return generation_.load() != seen; });
      seen = generation_.load();
      if (stop_) return;
    }
    drain(thread);
    if (active_workers_.fetch_sub(1) == 1) {
      std::lock_guard lock(mutex_);
      done_.notify_one();
    }
  }
}

}  // namespace stark
