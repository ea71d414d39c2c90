#include "deja_view/base/parallel.hpp"

#include <algorithm>

#include <tbb/blocked_range.h>
#include <tbb/parallel_for.h>
#include <tbb/task_arena.h>

namespace deja_view {

void ParallelFor(int threads,
                 std::size_t count,
                 const std::function<void(std::size_t begin, std::size_t end)>& body,
                 std::size_t grain) {
  if (count == 0) {
    return;
  }
  if (threads == 1) {
    body(0, count);
    return;
  }
  tbb::task_arena arena(threads > 0 ? threads : tbb::task_arena::automatic);
  arena.execute([&] {
    tbb::parallel_for(
        tbb::blocked_range<std::size_t>(0, count, std::max<std::size_t>(1, grain)),
        [&](const tbb::blocked_range<std::size_t>& range) { body(range.begin(), range.end()); });
  });
}

}  // namespace deja_view
