#pragma once

#include <cstddef>
#include <cstdint>

#include <thrust/execution_policy.h>
#include <thrust/for_each.h>
#include <thrust/iterator/counting_iterator.h>
#include <thrust/scan.h>
#include <thrust/sort.h>

// The thin layer over Thrust: all that is not the same code on every device.

namespace deja_view::nerf::internal {

/// Calls f(0) to f(count - 1), in any order and at the same time.
template <typename System, typename Function>
void ForEach(std::size_t count, const Function& f) {
  if (count > 0) {
    thrust::for_each_n(System::policy(), thrust::counting_iterator<std::size_t>(0), count, f);
  }
}

/// out[i] = in[0] + ... + in[i - 1]. May work in place.
template <typename System>
void ScanBefore(const std::size_t* in, std::size_t count, std::size_t* out) {
  thrust::exclusive_scan(System::policy(), in, in + count, out, std::size_t{0});
}

/// By keys; of equal ones the order is kept.
template <typename System>
void SortByKey(std::uint32_t* keys, std::size_t count, std::uint32_t* values) {
  thrust::stable_sort_by_key(System::policy(), keys, keys + count, values);
}

}  // namespace deja_view::nerf::internal
