#include "device_batches.hpp"

#include <algorithm>
#include <utility>

#include "ray_march.hpp"
#include <fmt/format.h>

namespace deja_view::nerf::internal {
namespace {

constexpr std::size_t kMostRays = 1 << 16;       // more than any card has threads at a time
constexpr std::size_t kMostBytes = 256U << 20U;  // of the samples of all rays

std::size_t Megabytes(std::size_t bytes) {
  return (bytes + (1U << 20U) - 1) >> 20U;
}

}  // namespace

DeviceBatches::DeviceBatches(std::string device, const MarchOptions& march, std::size_t fixed_bytes)
    : device_(std::move(device)),
      bytes_per_ray_((static_cast<std::size_t>(march.max_samples) + kSamplesPerRound) *
                     sizeof(float)),
      fixed_bytes_(fixed_bytes),
      size_(std::clamp(kMostBytes / bytes_per_ray_, kLeast, kMostRays)) {}

void DeviceBatches::Try(const std::function<void()>& work, const std::function<void()>& undo) {
  for (;;) {
    try {
      work();
      return;
    } catch (const DeviceMemoryError& e) {
      if (size_ <= kLeast) {
        throw DeviceMemoryError(fmt::format(
            "{}: {}: expected {} MB free for the field and what goes with it, and {} MB for the "
            "least number of rays",
            device_,
            e.what(),
            Megabytes(fixed_bytes_),
            Megabytes(kLeast * bytes_per_ray_)));
      }
      size_ = std::max(kLeast, size_ / 2);
      undo();
    }
  }
}

}  // namespace deja_view::nerf::internal
