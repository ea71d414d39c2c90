#pragma once

#include "deja_view/lab/sim/random.hpp"

#include <cstdint>
#include <vector>

#include <opencv2/core/mat.hpp>

namespace deja_view::sim {

/// Square grey texture that repeats in both directions, with a mip pyramid of 2x2 means (Williams,
/// SIGGRAPH 1983), so that a distant surface shows its mean and does not flicker.
class Texture {
 public:
  /// `reflectance`: CV_32FC1 in [0, 1], square, size a power of two; throws CheckError otherwise.
  explicit Texture(const cv::Mat& reflectance);

  int size() const { return size_; }      ///< [texels] of the finest level
  int levels() const { return levels_; }  ///< the coarsest is one texel

  /// Reflectance at (u, v), in periods: the texture covers [0, 1) x [0, 1), texel centres at (i +
  /// 0.5)/size. `footprint` [periods] is the width of what is averaged; bilinear in the level,
  /// linear between two.
  float Sample(float u, float v, float footprint) const;

  /// Bilinear lookup in one level; the reference for Sample.
  float SampleLevel(int level, float u, float v) const;

  /// For vector code: all levels, row by row. Each entry holds the four texels of a bilinear
  /// lookup, (x, y), (x + 1, y), (x, y + 1), (x + 1, y + 1), as bytes from the lowest: a single
  /// load. A byte is 255 times the square root of the reflectance, which spends its steps where
  /// eyes and gamma do.
  const std::uint32_t* texels() const { return texels_.data(); }
  const std::int32_t* level_offsets() const { return offsets_.data(); }

 private:
  int size_ = 0;
  int levels_ = 0;
  std::vector<std::int32_t> offsets_;
  std::vector<std::uint32_t> texels_;
};

/// What a surface is made of.
enum class Material {
  kConcrete,
  kPlaster,
  kBrick,
  kPlanks,
  kPanels,
  kPoster,
  kShelf,
  kCamouflage,
  kLacquer  ///< black, with next to nothing to see on it
};

/// Draws a texture of `size` x `size` texels. `strength` scales its contrast about its mean.
Texture MakeTexture(Material material, int size, double strength, Rng rng);

}  // namespace deja_view::sim
