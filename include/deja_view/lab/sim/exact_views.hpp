#pragma once

#include "deja_view/lab/sim/renderer.hpp"
#include "deja_view/views/virtual_view.hpp"

#include <cstdint>
#include <memory>
#include <string>
#include <vector>

namespace deja_view::sim {

/// Which views beside a real image are rendered exactly: what a perfect model of the hall would
/// give. An upper bound for views rendered from a learnt one.
struct ExactViewOptions {
  int count = 4;                ///< views per image
  double min_distance_m = 0.3;  ///< [m] from the real camera
  double max_distance_m = 0.8;  ///< [m]
  double max_angle_deg = 15.0;  ///< [deg] about each axis; a third of it about the viewing axis
  double clearance_m = 0.3;     ///< [m] to walls and furniture, at least
  double target_level = 0.22;   ///< mean linear level of an image
  double gamma = 1.7;
};

/// "paper": 2 views within 2 cm and 1 degree (Sec. 3.2.2); "wide": 4 views at 0.3 to 0.8 m and up
/// to 15 degrees. Throws InputError for another name.
ExactViewOptions MakeExactViewPreset(const std::string& name);
std::vector<std::string> ExactViewPresetNames();

/// Poses T_C_V of the views of the image at T_W_C; fewer than `count` where the hall leaves no
/// room. Deterministic in (T_W_C, options, seed).
std::vector<Rigid3> SampleExactViewPoses(const World& world,
                                         const Rigid3& T_W_C,
                                         const ExactViewOptions& options,
                                         std::uint64_t seed);

/// One view: sharp image without noise, exact depth, certain everywhere.
VirtualView RenderExactView(const Renderer& renderer,
                            std::shared_ptr<const Camera> camera,
                            const Rigid3& T_W_C,
                            const Rigid3& T_C_V,
                            const ExactViewOptions& options);

}  // namespace deja_view::sim
