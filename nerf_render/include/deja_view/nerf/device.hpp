#pragma once

#include <cstddef>
#include <memory>
#include <stdexcept>
#include <string>
#include <vector>

namespace deja_view::nerf {

namespace internal {
class DeviceEngine;
}

/// A graphics card.
struct DeviceCard {
  int number = 0;  ///< n of "cuda:n"
  std::string name;
  int compute_major = 0;
  int compute_minor = 0;
  std::size_t memory_bytes = 0;
};

/// What a machine has for fields to be computed on.
struct DeviceReport {
  std::vector<DeviceCard> cards;  ///< that can be used
  std::string problem;            ///< why there are none; empty where there are
  std::string driver;             ///< its version; empty without one
  std::string runtime;            ///< version that this build is made for; empty without CUDA
};

/// Something went wrong on a card; what() has the driver's words.
class DeviceError : public std::runtime_error {
  using std::runtime_error::runtime_error;
};

/// The card is gone or its state is broken: nothing more can be had from it.
class DeviceLostError : public DeviceError {
  using DeviceError::DeviceError;
};

/// The card has no memory left for this; less at a time may fit.
class DeviceMemoryError : public DeviceError {
  using DeviceError::DeviceError;
};

/// A way to compute fields elsewhere than on the CPU: CUDA's, or a stand-in in tests.
class DevicePlatform {
 public:
  virtual ~DevicePlatform() = default;

  /// Never throws, also without a driver.
  virtual DeviceReport Find() const = 0;

  /// The card of this number. Throws DeviceError.
  virtual std::unique_ptr<internal::DeviceEngine> Open(int card) const = 0;
};

/// CUDA's; in a build without CUDA it reports that it is one.
const DevicePlatform& CudaPlatform();

/// Where a field is trained or rendered; by default on the CPU.
struct DeviceChoice {
  const DevicePlatform* platform = nullptr;  ///< null: the CPU
  int card = 0;

  bool IsCpu() const { return platform == nullptr; }
};

/// What was chosen, and what the user should hear about it once.
struct ChosenDevice {
  DeviceChoice device;
  std::string note;  ///< empty: nothing
};

/// `name` is "auto" (the first card, or else the CPU), "cpu", "cuda" or "cuda:n". Throws InputError
/// for another name, and for a card that is not there.
ChosenDevice ChooseDevice(const std::string& name, const DevicePlatform& platform = CudaPlatform());

}  // namespace deja_view::nerf
