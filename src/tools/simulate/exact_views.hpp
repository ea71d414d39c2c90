#pragma once

#include "deja_view/features/feature_extractor.hpp"
#include "deja_view/lab/sim/exact_views.hpp"
#include "deja_view/lab/sim/simulator.hpp"

#include <cstdint>
#include <memory>
#include <string>
#include <vector>

#include "simulate/simulate_request.hpp"

namespace deja_view {

/// Renders the exact views of a simulated flight's images.
class ExactViews {
 public:
  /// Throws InputError for an unknown `request.virtual_views`. Refers to `simulator`.
  ExactViews(const sim::Simulator& simulator, const SimulateRequest& request);

  /// Views of the image at `stamp_ns`, at poses of the preset's.
  std::vector<VirtualView> Render(std::int64_t stamp_ns) const;

  /// The view at a pose.
  VirtualView RenderAt(std::int64_t stamp_ns, const Rigid3& T_C_V) const;

 private:
  Rigid3 CameraPose(std::int64_t stamp_ns) const;

  const sim::Simulator& simulator_;
  sim::ExactViewOptions options_;
  std::string content_;
  std::unique_ptr<FeatureExtractor> extractor_;
};

}  // namespace deja_view
