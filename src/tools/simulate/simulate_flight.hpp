#pragma once

#include "simulate/simulate_request.hpp"
#include <nlohmann/json.hpp>

namespace deja_view {

/// Simulates a flight and writes its files; returns the documented JSON keys. Throws InputError for
/// bad options or files that can't be written, Interrupted after Ctrl-C.
nlohmann::ordered_json RunSimulate(const SimulateRequest& request);

}  // namespace deja_view
