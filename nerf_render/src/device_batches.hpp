#pragma once

#include "deja_view/nerf/device.hpp"
#include "deja_view/nerf/options.hpp"

#include <cstddef>
#include <functional>
#include <string>

namespace deja_view::nerf::internal {

/// How many rays go to a device at a time: as many as its memory has room for.
class DeviceBatches {
 public:
  static constexpr std::size_t kLeast = 256;

  /// `fixed_bytes` are what the work takes however few rays there are, for messages.
  DeviceBatches(std::string device, const MarchOptions& march, std::size_t fixed_bytes);

  std::size_t size() const { return size_; }

  /// Calls work(). While the device's memory is exhausted, halves the size, calls `undo` and tries
  /// again. Throws DeviceMemoryError that tells what is needed where the least is too much.
  void Try(const std::function<void()>& work, const std::function<void()>& undo);

 private:
  std::string device_;
  std::size_t bytes_per_ray_;
  std::size_t fixed_bytes_;
  std::size_t size_;
};

}  // namespace deja_view::nerf::internal
