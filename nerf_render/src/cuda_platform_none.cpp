#include "deja_view/base/check.hpp"
#include "deja_view/nerf/device.hpp"

#include "device_engine.hpp"

namespace deja_view::nerf {
namespace {

class NoCards final : public DevicePlatform {
 public:
  DeviceReport Find() const override {
    DeviceReport report;
    report.problem = "this build has no CUDA (DEJA_VIEW_CUDA)";
    return report;
  }
  std::unique_ptr<internal::DeviceEngine> Open(int /*card*/) const override {
    throw DeviceError(Find().problem);
  }
};

}  // namespace

const DevicePlatform& CudaPlatform() {
  static const NoCards kNone;
  return kNone;
}

}  // namespace deja_view::nerf
