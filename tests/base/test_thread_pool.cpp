// The thread pool: every task exactly once, the same split for any number of threads, exceptions reach the
// caller.
#include <stark/base/for_each_range.h>
#include <stark/base/thread_pool.h>

#include <atomic>
#include <chrono>
#include <memory>
#include <numeric>
#include <set>
#include <stdexcept>
#include <thread>
#include <utility>
#include <vector>

#include <doctest/doctest.h>
#include <sched.h>
#include <sys/wait.h>
#include <unistd.h>

using stark::ThreadPool;

TEST_CASE("every task runs exactly once, on a valid thread") {
  for (int threads : {1, 2, 5}) {
    ThreadPool pool(threads);
    REQUIRE(pool.thread_count() == threads);
    for (int64_t tasks : {0, 1, 2, 7, 1000}) {
      std::vector<std::atomic<int>> count(static_cast<size_t>(tasks));
      std::atomic<bool> valid{true};
      pool.for_each_task(tasks, [&](int64_t task, int thread) {
        count[static_cast<size_t>(task)].fetch_add(1);
        if (thread < 0 || thread >= threads) valid = false;
      });
      CHECK(valid);
      for (const auto& c : count) CHECK(c.load() == 1);
    }
  }
}

TEST_CASE("ranges cover everything once and do not depend on the number of threads") {
  const auto ranges = [](int threads, int64_t count, int64_t grain) {
    ThreadPool pool(threads);
    std::vector<std::pair<int64_t, int64_t>> found(static_cast<size_t>((count + grain - 1) / grain));
    pool.for_each_range(count, grain, [&](int64_t begin, int64_t end) {
      found[static_cast<size_t>(begin / grain)] = {begin, end};
    });
    return found;
  };
  for (int64_t count : {0, 1, 63, 64, 65, 1000}) {
    const auto expected = ranges(1, count, 64);
    int64_t covered = 0;
    for (const auto& [begin, end] : expected) {
      CHECK(begin == covered);
      CHECK(end - begin <= 64);
      covered = end;
    }
    CHECK(covered == count);
    CHECK(ranges(2, count, 64) == expected);
    CHECK(ranges(5, count, 64) == expected);
  }
}

TEST_CASE("chunked sums have the same bits for 1, 2 and 5 threads") {
  std::vector<double> values(100'000);
  for (size_t i = 0; i < values.size(); ++i) values[i] = 1.0 / static_cast<double>(3 * i + 1);
  const auto sum = [&](int threads) {
    ThreadPool pool(threads);
    constexpr int64_t kGrain = 512;
    std::vector<double> partial((values.size() + kGrain - 1) / kGrain);
    pool.for_each_range(static_cast<int64_t>(values.size()), kGrain, [&](int64_t begin, int64_t end) {
      partial[static_cast<size_t>(begin / kGrain)] =
          std::accumulate(values.begin() + begin, values.begin() + end, 0.0);
    });
    return std::accumulate(partial.begin(), partial.end(), 0.0);
  };
  CHECK(sum(2) == sum(1));
  CHECK(sum(5) == sum(1));
}

TEST_CASE("short jobs follow each other while workers wake up, sleep and come too late") {
  ThreadPool pool(5);
  std::vector<int64_t> sums(8), expected(8);
  for (int round = 0; round < 20'000; ++round) {
    if (round % 4000 == 0) std::this_thread::sleep_for(std::chrono::milliseconds(5));
    const int64_t tasks = 2 + round % 7;
    for (int64_t task = 0; task < tasks; ++task) ++expected[task];
    pool.for_each_task(tasks, [&](int64_t task, int) { sums[task] += round; });  // without a lock
    pool.for_each_task(tasks, [&](int64_t task, int) { sums[task] -= round - 1; });
  }
  CHECK(sums == expected);
}

TEST_CASE("an exception of a task reaches the caller and the pool stays usable") {
  for (int threads : {1, 2, 5}) {
    ThreadPool pool(threads);
    for (int round = 0; round < 20; ++round) {
      CHECK_THROWS_AS(pool.for_each_task(50,
                                         [](int64_t task, int) {
                                           if (task == 17) throw std::runtime_error("task 17");
                                         }),
                      std::runtime_error);
      std::atomic<int64_t> sum{0};
      pool.for_each_task(50, [&](int64_t task, int) { sum += task; });
      CHECK(sum == 50 * 49 / 2);
    }
  }
}

TEST_CASE("many short regions in a row lose no task") {
  ThreadPool pool(3);
  std::atomic<int64_t> sum{0};
  for (int round = 0; round < 5000; ++round)
    pool.for_each_task(4, [&](int64_t task, int) { sum += task + 1; });
  CHECK(sum == 5000 * 10);
}

TEST_CASE("a pool goes on in a forked process, in the parent and in a child of the child") {
  const auto sum = [](ThreadPool& pool) {
    std::atomic<int64_t> total{0};
    pool.for_each_task(100, [&](int64_t task, int) { total += task; });
    return total.load();
  };
  const auto in_a_child = [](const auto& act) {
    const pid_t child = fork();
    if (child == 0) {
      alarm(20);  // rather than to hang
      _exit(act() ? 0 : 1);
    }
    int status = -1;
    waitpid(child, &status, 0);
    return status;
  };
  for (const bool has_run : {false, true}) {
    ThreadPool pool(4);
    if (has_run) CHECK(sum(pool) == 4950);
    CHECK(in_a_child([&] {
            return sum(pool) == 4950 && in_a_child([&] { return sum(pool) == 4950; }) == 0 &&
                   sum(pool) == 4950;
          }) == 0);
    CHECK(sum(pool) == 4950);
    CHECK(pool.thread_count() == 4);
  }
}

TEST_CASE("a child that uses nothing of the pool may destroy it") {
  auto pool = std::make_unique<ThreadPool>(4);
  const pid_t child = fork();
  if (child == 0) {
    alarm(20);
    pool.reset();
    _exit(0);
  }
  int status = -1;
  waitpid(child, &status, 0);
  CHECK(status == 0);
}

TEST_CASE("no more threads are used than processors may be") {
  cpu_set_t all;
  REQUIRE(sched_getaffinity(0, sizeof(all), &all) == 0);
  const int most = stark::usable_threads(0);
  CHECK(most >= 1);
  CHECK(most <= CPU_COUNT(&all));
  CHECK(stark::usable_threads(1) == 1);
  CHECK(stark::usable_threads(1000) == most);

  cpu_set_t one;
  CPU_ZERO(&one);
  for (int cpu = 0; CPU_COUNT(&one) == 0; ++cpu)
    if (CPU_ISSET(cpu, &all)) CPU_SET(cpu, &one);
  REQUIRE(sched_setaffinity(0, sizeof(one), &one) == 0);
  CHECK(stark::usable_threads(0) == 1);
  CHECK(stark::usable_threads(64) == 1);
  sched_setaffinity(0, sizeof(all), &all);
}

TEST_CASE("ranges without a pool are one range") {
  ThreadPool pool(3);
  for (ThreadPool* const with : {static_cast<ThreadPool*>(nullptr), &pool}) {
    std::vector<int64_t> seen(10, 0);
    std::atomic<int> ranges{0};
    for_each_range(with, std::ssize(seen), 4, [&](int64_t begin, int64_t end) {
      ++ranges;
      for (int64_t i = begin; i < end; ++i) seen[i] = i + 1;
    });
    CHECK(ranges.load() == (with == nullptr ? 1 : 3));
    for (int64_t i = 0; i < std::ssize(seen); ++i) CHECK(seen[i] == i + 1);
  }
}
