#include "deja_view/nerf/occupancy_grid.hpp"

#include "deja_view/base/check.hpp"

#include <algorithm>
#include <cmath>
#include <utility>

namespace deja_view::nerf {
namespace {

constexpr std::uint8_t kFarthest = 15;  ///< blocks

// Distances along lines of bytes that are 0 or kFarthest.
void MeasureAlongLines(std::size_t length, std::vector<std::uint8_t>* distances) {
  for (auto line = distances->begin(); line != distances->end();
       line += static_cast<std::ptrdiff_t>(length)) {
    const auto shorten = [](std::uint8_t before, std::uint8_t& here) {
      here = std::min<std::uint8_t>(here, static_cast<std::uint8_t>(before + 1));
    };
    for (std::size_t i = 1; i < length; ++i) {
      shorten(line[static_cast<std::ptrdiff_t>(i) - 1], line[static_cast<std::ptrdiff_t>(i)]);
    }
    for (std::size_t i = length - 1; i > 0; --i) {
      shorten(line[static_cast<std::ptrdiff_t>(i)], line[static_cast<std::ptrdiff_t>(i) - 1]);
    }
  }
}

// The largest difference of coordinates, extended to one more axis: `count` slices of `stride`.
void MeasureAcrossSlices(std::size_t count,
                         std::size_t stride,
                         std::vector<std::uint8_t>* distances) {
  const std::vector<std::uint8_t> from = *distances;
  for (std::size_t begin = 0; begin < from.size(); begin += count * stride) {
    for (std::size_t i = 0; i < count; ++i) {
      std::uint8_t* out = distances->data() + begin + i * stride;
      const std::size_t last = std::min(count - 1, i + kFarthest);
      for (std::size_t j = i - std::min<std::size_t>(i, kFarthest); j <= last; ++j) {
        const std::uint8_t* in = from.data() + begin + j * stride;
        const auto apart = static_cast<std::uint8_t>(i > j ? i - j : j - i);
        for (std::size_t k = 0; k < stride; ++k) {
          out[k] = std::min(out[k], std::max(apart, in[k]));
        }
      }
    }
  }
}

}  // namespace

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
  leaps_.assign(words_.size(), 0);
}

void OccupancyGrid::SetWords(std::vector<std::uint64_t> words) {
  DEJA_VIEW_CHECK(words.size() == words_.size());
  words_ = std::move(words);
  FindLeaps();
}

void OccupancyGrid::FindLeaps() {
  std::transform(words_.begin(), words_.end(), leaps_.begin(), [](std::uint64_t word) {
    return word == 0 ? kFarthest : std::uint8_t{0};
  });
  const auto width = static_cast<std::size_t>(blocks_[0]);
  const auto height = static_cast<std::size_t>(blocks_[1]);
  MeasureAlongLines(width, &leaps_);
  MeasureAcrossSlices(height, width, &leaps_);
  MeasureAcrossSlices(static_cast<std::size_t>(blocks_[2]), width * height, &leaps_);
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
