#include "simulate/simulate_request.hpp"

#include "deja_view/io/options_yaml.hpp"

namespace deja_view {

sim::SimOptions ReadSimOptions(const SimulateRequest& request) {
  sim::SimOptions options = sim::MakePreset(request.preset);
  ReadOptions(request.config, request.overrides, &options);
  return options;
}

}  // namespace deja_view
