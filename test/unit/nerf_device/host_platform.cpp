#include "host_platform.hpp"

#include <limits>
#include <memory>

#include "engine.cuh"
#include "host_system.hpp"

namespace deja_view::nerf::internal {

DeviceReport HostPlatform::Find() const {
  DeviceReport report;
  report.cards.push_back({0, "a stand-in", 0, 0, 0});
  report.runtime = "0.0";
  return report;
}

std::unique_ptr<DeviceEngine> HostPlatform::Open(int card) const {
  return std::make_unique<Engine<HostSystem>>(card, "a stand-in");
}

void SetHostMemory(std::size_t bytes) {
  HostSystem::memory_bytes = bytes;
}

std::size_t HostBytes() {
  return HostSystem::used_bytes;
}

void LoseHostAfter(std::size_t calls) {
  HostSystem::calls_left = calls;
}

void HealHost() {
  HostSystem::memory_bytes = std::numeric_limits<std::size_t>::max();
  HostSystem::calls_left = std::numeric_limits<std::size_t>::max();
}

}  // namespace deja_view::nerf::internal
