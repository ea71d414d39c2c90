#pragma once

#include "deja_view/base/host_device.hpp"
#include "deja_view/base/random.hpp"

#include <cstddef>
#include <cstdint>

namespace deja_view::nerf::internal {

/// An 8-bit image, row by row.
struct PixelRows {
  const std::uint8_t* pixels = nullptr;
  int width = 0;
  int height = 0;
  std::size_t channels = 1;
  std::size_t row = 0;  ///< bytes from one row to the next
};

/// Which squares of pixels rays are cast through.
struct SquareOptions {
  int side = 4;                 ///< [px], at most any image's sides
  float textured_share = 0.5F;  ///< of the squares: the one with most contrast of
  int textured_of = 4;          ///< so many
};

/// A square's upper left pixel.
struct SquareCorner {
  int x = 0;
  int y = 0;
};

/// Random numbers that DrawSquare takes, whatever they are.
DEJA_VIEW_HOST_DEVICE inline std::size_t NumbersPerSquare(const SquareOptions& options) {
  return 1 + 2 * static_cast<std::size_t>(options.textured_of);
}

/// Between the brightest and the darkest pixel of a square, in the first channel.
DEJA_VIEW_HOST_DEVICE inline int Contrast(const PixelRows& image, SquareCorner at, int side) {
  int least = 255;
  int most = 0;
  for (int y = at.y; y < at.y + side; ++y) {
    const std::uint8_t* row = image.pixels + static_cast<std::size_t>(y) * image.row;
    for (int x = at.x; x < at.x + side; ++x) {
      const int value = row[static_cast<std::size_t>(x) * image.channels];
      least = value < least ? value : least;
      most = value > most ? value : most;
    }
  }
  return most - least;
}

/// A random square of an image: anywhere in it, or, in a share of the cases, where it shows
/// something, which is where keypoints are.
DEJA_VIEW_HOST_DEVICE inline SquareCorner DrawSquare(const PixelRows& image,
                                                     const SquareOptions& options,
                                                     Random* random) {
  const bool is_textured = random->UniformFloat() < options.textured_share;
  SquareCorner best;
  int most = -1;
  for (int i = 0; i < options.textured_of; ++i) {
    SquareCorner at;
    at.x =
        static_cast<int>(random->Index(static_cast<std::uint32_t>(image.width - options.side + 1)));
    at.y = static_cast<int>(
        random->Index(static_cast<std::uint32_t>(image.height - options.side + 1)));
    const int contrast = is_textured ? Contrast(image, at, options.side) : 0;
    if (contrast > most) {
      most = contrast;
      best = at;
    }
  }
  return best;
}

}  // namespace deja_view::nerf::internal
