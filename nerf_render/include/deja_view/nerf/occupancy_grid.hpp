#pragma once

#include "deja_view/nerf/occupancy_view.hpp"

#include <array>
#include <cstddef>
#include <cstdint>
#include <vector>

#include <Eigen/Core>

namespace deja_view::nerf {

/// Which cells of the scene hold matter, one bit each in blocks of 4x4x4 (one word), and how far
/// the nearest block with matter is, so that a ray leaps over empty space. Positions in unit
/// coordinates.
class OccupancyGrid {
 public:
  OccupancyGrid() = default;
  /// `resolution` cells along a unit length; all occupied at first.
  OccupancyGrid(int resolution, const Eigen::Vector3f& extent);

  const std::array<int, 3>& cells() const { return cells_; }  ///< per axis, multiples of 4
  float scale() const { return scale_; }                      ///< cells per unit length
  std::size_t cell_count() const { return words_.size() * 64; }
  const std::vector<std::uint64_t>& words() const { return words_; }

  /// Index of a cell: 64 block + place in the block.
  std::size_t Index(int x, int y, int z) const { return view().Index(x, y, z); }
  /// Coordinates of a cell's lowest corner, in cells.
  std::array<int, 3> Cell(std::size_t index) const { return view().Cell(index); }

  bool IsOccupied(std::size_t index) const {
    return (words_[index / 64] >> (index % 64) & 1U) != 0;
  }
  /// Of a word per block. Finds the leaps, too.
  void SetWords(std::vector<std::uint64_t> words);
  /// Leaps may be too wide until FindLeaps() is called. Different blocks may be set by different
  /// threads.
  void Set(std::size_t index, bool occupied);
  void FindLeaps();
  /// With a leap of n >= 1, all blocks within n - 1 blocks of this one on each axis are empty.
  int leap(std::size_t block) const { return leaps_[block]; }
  std::size_t CountOccupied() const;

  /// Until the grid is changed.
  OccupancyView view() const { return {cells_, blocks_, scale_, words_.data(), leaps_.data()}; }

 private:
  std::array<int, 3> cells_{};
  std::array<int, 3> blocks_{};
  float scale_ = 1;
  std::vector<std::uint64_t> words_;
  std::vector<std::uint8_t> leaps_;  ///< per block
};

}  // namespace deja_view::nerf
