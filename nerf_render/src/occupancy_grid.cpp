#include "deja_view/nerf/occupancy_grid.hpp"

#include <cmath>

namespace deja_view::nerf {

OccupancyGrid::OccupancyGrid(int resolution, const Eigen::Vector3f& extent)
    : scale_(static_cast<float>(resolution)) {
  for (std::size_t axis = 0; axis < 3; ++axis) {
    blocks_[axis] = static_cast<int>(
        std::ceil(extent[static_cast<Eigen::Index>(axis)] * scale_ / 4.0F - 1e-4F));
    blocks_[axis] = blocks_[axis] < 1 ? 1 : blocks_[axis];
    cells_[axis] = 4 * blocks_[axis];
  }
  words_.assign(static_cast<std::size_t>(blocks_[0]) * static_cast<std::size_t>(blocks_[1]) *
                    static_cast<std::size_t>(blocks_[2]),
                ~std::uint64_t{0});
}

std::array<int, 3> OccupancyGrid::Cell(std::size_t index) const {
  const auto block = static_cast<int>(index / 64);
  const auto place = static_cast<int>(index % 64);
  return {4 * (block % blocks_[0]) + place % 4,
          4 * (block / blocks_[0] % blocks_[1]) + place / 4 % 4,
          4 * (block / (blocks_[0] * blocks_[1])) + place / 16};
}

void OccupancyGrid::Set(std::size_t index, bool occupied) {
  const std::uint64_t bit = std::uint64_t{1} << (index % 64);
  if (occupied) {
    words_[index / 64] |= bit;
  } else {
    words_[index / 64] &= ~bit;
  }
}

std::size_t OccupancyGrid::CountOccupied() const {
  std::size_t count = 0;
  for (const std::uint64_t word : words_) {
    count += static_cast<std::size_t>(__builtin_popcountll(word));
  }
  return count;
}

}  // namespace deja_view::nerf
