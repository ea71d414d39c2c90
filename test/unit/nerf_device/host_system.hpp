#pragma once

#include "deja_view/nerf/device.hpp"

#include <cstddef>
#include <cstdlib>
#include <cstring>
#include <limits>
#include <map>

#include <thrust/execution_policy.h>

namespace deja_view::nerf::internal {

/// The host as a stand-in for a card, whose memory may be small and which may be lost.
struct HostSystem {
  static inline std::size_t memory_bytes = std::numeric_limits<std::size_t>::max();
  static inline std::size_t used_bytes = 0;
  static inline std::size_t calls_left = std::numeric_limits<std::size_t>::max();

  static void Select(int /*card*/) {
    if (calls_left == 0) {
      throw DeviceLostError("the card has fallen off the bus");
    }
    --calls_left;
  }
  static std::size_t UsedBytes() { return used_bytes; }
  static void* Allocate(std::size_t bytes) {
    if (bytes > memory_bytes - used_bytes) {
      throw DeviceMemoryError("out of memory");
    }
    used_bytes += bytes;
    void* memory = std::malloc(bytes);
    // What nobody wrote is not zero.
    std::memset(memory, 0xff, bytes);
    sizes()[memory] = bytes;
    return memory;
  }
  static void Free(void* memory) {
    used_bytes -= sizes().at(memory);
    sizes().erase(memory);
    std::free(memory);
  }
  static void Upload(const void* from, std::size_t bytes, void* to) {
    std::memcpy(to, from, bytes);
  }
  static void Download(const void* from, std::size_t bytes, void* to) {
    std::memcpy(to, from, bytes);
  }
  static void Clear(void* memory, std::size_t bytes) { std::memset(memory, 0, bytes); }
  static void Finish() {}
  static auto policy() { return thrust::device; }

 private:
  static std::map<void*, std::size_t>& sizes() {
    static std::map<void*, std::size_t> sizes;
    return sizes;
  }
};

}  // namespace deja_view::nerf::internal
