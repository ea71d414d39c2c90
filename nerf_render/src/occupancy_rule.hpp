#pragma once

namespace deja_view::nerf::internal {

constexpr float kOccupancyDecay = 0.9F;        ///< of a cell's density, per look
constexpr double kOccupancyShareOfMean = 0.5;  ///< of the mean density: less is empty

}  // namespace deja_view::nerf::internal
