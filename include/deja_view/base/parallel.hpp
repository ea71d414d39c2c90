#pragma once

#include <cstddef>
#include <functional>

namespace deja_view {

/// Calls `body(begin, end)` over disjoint ranges that cover [0, count), on at most `threads`
/// threads (0: all cores; 1: in the caller's thread). Returns when all are done.
///
/// Which thread gets which range depends on timing: `body` must give the same result for every
/// partition, so write to per-index outputs and reduce afterwards in index order.
void ParallelFor(int threads,
                 std::size_t count,
                 const std::function<void(std::size_t begin, std::size_t end)>& body,
                 std::size_t grain = 1);

}  // namespace deja_view
