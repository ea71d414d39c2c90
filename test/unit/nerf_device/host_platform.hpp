#pragma once

#include "deja_view/nerf/device.hpp"

namespace deja_view::nerf::internal {

/// The host in a card's place, with the card's code.
class HostPlatform final : public DevicePlatform {
 public:
  DeviceReport Find() const override;
  std::unique_ptr<DeviceEngine> Open(int card) const override;
};

/// What the host stands in for: a card with little memory, or one that is lost.
void SetHostMemory(std::size_t bytes);
std::size_t HostBytes();
void LoseHostAfter(std::size_t calls);
/// Plenty of memory, and never lost.
void HealHost();

inline const HostPlatform& Host() {
  static const HostPlatform kHost;
  return kHost;
}

}  // namespace deja_view::nerf::internal
