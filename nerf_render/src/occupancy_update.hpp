#pragma once

#include "deja_view/nerf/radiance_field.hpp"
#include "deja_view/nerf/training_view.hpp"

#include <cstdint>
#include <vector>

namespace deja_view::nerf::internal {

/// Keeps a field's occupancy grid: a cell is occupied while a decaying maximum of its density, seen
/// at random places within it, could dim a ray by the threshold in a step.
class OccupancyUpdate {
 public:
  /// Marks the blocks that no view can see as empty for ever: nothing there is ever trained.
  /// So are cells in front of at least `carve_votes` depth points and not beside any.
  OccupancyUpdate(const std::vector<TrainingView>& views,
                  int threads,
                  int carve_votes,
                  RadianceField* field);

  /// `open`: the cells that may hold matter, a word per block as in OccupancyGrid.
  explicit OccupancyUpdate(std::vector<std::uint64_t> open);

  /// `round` numbers the random draws. Looks at all cells that are occupied and at one in sixteen
  /// of the others, or at all if `full`.
  void Run(const Kernels& kernels,
           const TrainOptions& options,
           std::uint64_t round,
           bool full,
           RadianceField* field);

  /// Cells that may hold matter, as OccupancyGrid::words().
  const std::vector<std::uint64_t>& open() const { return open_; }

 private:
  /// Density above which a cell counts as occupied.
  float Threshold(const TrainOptions& options) const;
  void FindSeen(const std::vector<TrainingView>& views, int threads, const RadianceField& field);
  void Carve(const std::vector<TrainingView>& views, int votes, const RadianceField& field);

  std::vector<float> density_;       ///< per cell
  std::vector<std::uint64_t> open_;  ///< cells that may hold matter, as OccupancyGrid::words()
};

}  // namespace deja_view::nerf::internal
