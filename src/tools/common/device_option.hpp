#pragma once

#include "deja_view/nerf/device.hpp"

#include <string>

#include <CLI/CLI.hpp>

namespace deja_view {

/// What a tool's --device is at first.
inline constexpr const char* kAnyDevice = "auto";

/// The exit code of a tool whose card was lost: what is kept of its work can be gone on with.
constexpr int kDeviceLostCode = 75;

inline void AddDeviceOption(CLI::App* sub, std::string* device) {
  sub->add_option("--device",
                  *device,
                  "auto (a graphics card, or else the CPU), cpu, cuda or cuda:n; the code for "
                  "cards has not run on one yet: scripts/check_cuda tells whether it does")
      ->capture_default_str();
}

/// nerf::ChooseDevice; tells its note on the error stream.
nerf::DeviceChoice ChooseToolDevice(const std::string& name);

}  // namespace deja_view
