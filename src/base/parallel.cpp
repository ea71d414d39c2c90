#include "deja_view/base/parallel.hpp"

#include <algorithm>

#ifdef __SANITIZE_THREAD__
#include <future>
#include <thread>
#include <vector>
#else
#include <tbb/blocked_range.h>
#include <tbb/parallel_for.h>
#include <tbb/task_arena.h>
#endif

namespace deja_view {
namespace {

using Body = std::function<void(std::size_t begin, std::size_t end)>;

#ifdef __SANITIZE_THREAD__
// ThreadSanitizer can't see how TBB's library, which is not compiled with it, hands tasks over:
// what tasks do with each other's data is found on threads that it can see.
void RunInParallel(int threads, std::size_t count, const Body& body, std::size_t grain) {
  const std::size_t most =
      threads > 0 ? static_cast<std::size_t>(threads) : std::thread::hardware_concurrency();
  const std::size_t length = std::max(grain, (count + most - 1) / std::max<std::size_t>(1, most));
  std::vector<std::future<void>> parts;
  for (std::size_t begin = 0; begin < count; begin += length) {
    const std::size_t end = std::min(count, begin + length);
    parts.push_back(std::async(std::launch::async, [&body, begin, end] { body(begin, end); }));
  }
  for (std::future<void>& part : parts) {
    part.get();
  }
}
#else
void RunInParallel(int threads, std::size_t count, const Body& body, std::size_t grain) {
  tbb::task_arena arena(threads > 0 ? threads : tbb::task_arena::automatic);
  arena.execute([&] {
    tbb::parallel_for(
        tbb::blocked_range<std::size_t>(0, count, grain),
        [&](const tbb::blocked_range<std::size_t>& range) { body(range.begin(), range.end()); });
  });
}
#endif

}  // namespace

void ParallelFor(int threads, std::size_t count, const Body& body, std::size_t grain) {
  if (count == 0) {
    return;
  }
  if (threads == 1) {
    body(0, count);
    return;
  }
  RunInParallel(threads, count, body, std::max<std::size_t>(1, grain));
}

}  // namespace deja_view
