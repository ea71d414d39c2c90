#include "deja_view/nerf/device.hpp"

#include "deja_view/base/check.hpp"

#include <cstdlib>

namespace deja_view::nerf {
namespace {

constexpr const char* kCuda = "cuda";

// n of "cuda:n", 0 of "cuda"; -1 for what is neither.
int CardOf(const std::string& name) {
  if (name == kCuda) {
    return 0;
  }
  const std::string prefix = std::string(kCuda) + ":";
  const std::string number = name.substr(name.find(':') + 1);
  const bool is_number = !number.empty() && number.size() <= 3 &&
                         number.find_first_not_of("0123456789") == std::string::npos;
  return name.compare(0, prefix.size(), prefix) == 0 && is_number ? std::atoi(number.c_str()) : -1;
}

}  // namespace

ChosenDevice ChooseDevice(const std::string& name, const DevicePlatform& platform) {
  if (name == "cpu") {
    return {};
  }
  if (name == "auto") {
    const DeviceReport report = platform.Find();
    if (!report.cards.empty()) {
      const DeviceCard& card = report.cards.front();
      return {{&platform, card.number}, "using " + card.name};
    }
    return {{}, report.runtime.empty() ? "" : report.problem + "; using the CPU"};
  }
  const int card = CardOf(name);
  if (card < 0) {
    ThrowInputError("device '{}': expected auto, cpu, cuda or cuda:n", name);
  }
  const DeviceReport report = platform.Find();
  if (report.cards.empty()) {
    ThrowInputError("device '{}': {}", name, report.problem);
  }
  std::string numbers;
  for (const DeviceCard& found : report.cards) {
    if (found.number == card) {
      return {{&platform, card}, ""};
    }
    numbers += (numbers.empty() ? "" : ", ") + std::to_string(found.number);
  }
  ThrowInputError("device '{}': expected one of the cards that can be used: {}", name, numbers);
}

}  // namespace deja_view::nerf
