#include "deja_view/nerf/device.hpp"

#include <memory>
#include <string>

#include "cuda_system.cuh"
#include "engine.cuh"

#define DEJA_VIEW_EXPORT __attribute__((visibility("default")))

namespace deja_view::nerf {
namespace {

// 13000 is 13.0.
std::string VersionText(int version) {
  return std::to_string(version / 1000) + "." + std::to_string(version % 1000 / 10);
}

/// Cards by CUDA's runtime, which is part of this library; the driver is looked for when asked.
class CudaCards final : public DevicePlatform {
 public:
  DeviceReport Find() const override {
    DeviceReport report;
    int version = 0;
    cudaRuntimeGetVersion(&version);
    report.runtime = VersionText(version);
    int driver = 0;
    if (cudaDriverGetVersion(&driver) == cudaSuccess && driver > 0) {
      report.driver = VersionText(driver);
    }
    int count = 0;
    const cudaError_t result = cudaGetDeviceCount(&count);
    if (result != cudaSuccess || count == 0) {
      cudaGetLastError();
      report.problem = Problem(result, report);
      return report;
    }
    for (int card = 0; card < count; ++card) {
      cudaDeviceProp properties{};
      if (cudaGetDeviceProperties(&properties, card) != cudaSuccess) {
        break;
      }
      if (10 * properties.major + properties.minor < DEJA_VIEW_CUDA_LEAST) {
        report.problem = std::string(properties.name) + " is too old for this build";
        continue;
      }
      report.cards.push_back(
          {card, properties.name, properties.major, properties.minor, properties.totalGlobalMem});
    }
    if (!report.cards.empty()) {
      report.problem.clear();
    } else if (report.problem.empty()) {
      report.problem = "the graphics cards can't be asked what they are";
    }
    return report;
  }

  std::unique_ptr<internal::DeviceEngine> Open(int card) const override {
    internal::CudaSystem::Select(card);
    cudaDeviceProp properties{};
    internal::CheckCuda(cudaGetDeviceProperties(&properties, card), "asking the card what it is");
    return std::make_unique<internal::Engine<internal::CudaSystem>>(card, properties.name);
  }

 private:
  static std::string Problem(cudaError_t result, const DeviceReport& report) {
    if (report.driver.empty()) {
      return "no driver of a graphics card";
    }
    if (result == cudaErrorInsufficientDriver) {
      return "the graphics card's driver is for CUDA " + report.driver + ": expected " +
             report.runtime + " or newer";
    }
    if (result == cudaErrorNoDevice || result == cudaSuccess) {
      return "no graphics card";
    }
    return std::string("no graphics card can be used: ") + cudaGetErrorString(result);
  }
};

}  // namespace

DEJA_VIEW_EXPORT const DevicePlatform& CudaPlatform() {
  static const CudaCards kCards;
  return kCards;
}

}  // namespace deja_view::nerf
