#include "common/device_option.hpp"

#include <iostream>

namespace deja_view {

nerf::DeviceChoice ChooseToolDevice(const std::string& name) {
  const nerf::ChosenDevice chosen = nerf::ChooseDevice(name);
  if (!chosen.note.empty()) {
    std::cerr << "deja_view: " << chosen.note << "\n";
  }
  return chosen.device;
}

}  // namespace deja_view
