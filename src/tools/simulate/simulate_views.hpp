#pragma once

#include "simulate/simulate_request.hpp"
#include <nlohmann/json.hpp>

namespace deja_view {

/// Renders the views of a flight that was simulated before, `request.views_for` or
/// `request.views_like`; returns {virtual_views, wall_s}. Errors as RunSimulate.
nlohmann::ordered_json RunSimulateViews(const SimulateRequest& request);

}  // namespace deja_view
