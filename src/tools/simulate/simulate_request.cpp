#include "simulate/simulate_request.hpp"

#include "deja_view/io/options_yaml.hpp"

namespace deja_view {

sim::SimOptions ReadSimOptions(const SimulateRequest& request) {
  sim::SimOptions options = sim::MakePreset(request.preset);
  if (!request.config.empty()) {
    ReadOptions(request.config, &options);
  }
  for (const std::string& assignment : request.overrides) {
    OverrideOption(assignment, &options);
  }
  return options;
}

}  // namespace deja_view
