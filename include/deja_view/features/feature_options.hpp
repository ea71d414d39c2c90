#pragma once

#include "deja_view/base/enum_names.hpp"

#include <string>
#include <vector>

namespace deja_view {

/// How a tracked point's sub-pixel position becomes the pixel that BRIEF is centred on.
enum class PixelRounding {
  kNearest,   ///< nearest pixel
  kTruncate,  ///< towards zero, as VINS-Mono does: half a pixel up and left on average
};

template <>
inline constexpr auto kEnumNames<PixelRounding> = EnumNames("nearest", "truncate");

/// Options of BriefExtractor.
struct BriefOptions {
  int max_features = 1000;   ///< strongest corners kept; >= 1
  int fast_threshold = 14;   ///< grey levels, 1 to 254
  int cell_size_px = 24;     ///< corners are spread over square cells of this size; 0: no spreading
  std::string pattern_file;  ///< brief_pattern.yml; empty: the package's own pattern
  int smoothing_kernel_px = 9;  ///< odd size of the Gaussian kernel; 1: no smoothing
  double smoothing_sigma_px = 2.0;
  PixelRounding point_rounding = PixelRounding::kNearest;

  /// Violations, one line each; empty when all is well.
  std::vector<std::string> Validate() const;

  template <typename Visitor>
  void Visit(Visitor& v) {
    v("max_features", max_features);
    v("fast_threshold", fast_threshold);
    v("cell_size_px", cell_size_px);
    v("pattern_file", pattern_file);
    v("smoothing_kernel_px", smoothing_kernel_px);
    v("smoothing_sigma_px", smoothing_sigma_px);
    v("point_rounding", point_rounding);
  }
};

/// How ORB's corners are spread over a pyramid level by a quadtree (Sec. 3.2.3): a cell with more
/// than one corner splits in four until there are T cells with corners; the strongest corner of
/// each is kept.
enum class QuadtreeMode {
  kCount,  ///< T is the level's share of max_features
  kStd,    ///< for each quarter of the level, T is its grey values' standard deviation, as the
           ///< paper means it
  kAdaptiveFast,  ///< as kCount, after FAST with a threshold proportional to the local deviation
};

template <>
inline constexpr auto kEnumNames<QuadtreeMode> = EnumNames("count", "std", "adaptive_fast");

/// Options of OrbExtractor; the defaults are ORB-SLAM's, but for the quadtree's mode, which finds
/// more of the points that a VIO tracks.
struct OrbOptions {
  int max_features = 1000;    ///< over all levels; >= 1
  double scale_factor = 1.2;  ///< between levels, 1.01 to 2
  /// 1 to 16. Tracked points are described at the first: what is found on others shows no point.
  int levels = 1;
  int fast_threshold = 20;     ///< grey levels, 1 to 254
  int min_fast_threshold = 7;  ///< where a cell has no corner at fast_threshold; <= fast_threshold
  int cell_size_px = 35;       ///< of the cells that choose between the thresholds
  QuadtreeMode quadtree = QuadtreeMode::kAdaptiveFast;
  double adaptive_factor = 0.25;  ///< adaptive_fast: threshold over the cell's standard deviation

  /// Violations, one line each; empty when all is well.
  std::vector<std::string> Validate() const;

  template <typename Visitor>
  void Visit(Visitor& v) {
    v("max_features", max_features);
    v("scale_factor", scale_factor);
    v("levels", levels);
    v("fast_threshold", fast_threshold);
    v("min_fast_threshold", min_fast_threshold);
    v("cell_size_px", cell_size_px);
    v("quadtree", quadtree);
    v("adaptive_factor", adaptive_factor);
  }
};

/// Kind of descriptor; a vocabulary is trained for one of them.
enum class FeatureKind { kBrief, kOrb };

template <>
inline constexpr auto kEnumNames<FeatureKind> = EnumNames("brief", "orb");

/// How a patch is turned before it is described.
enum class PatchOrientation {
  kGravity,  ///< as it stands in the world: see VerticalField
  kImage,    ///< BRIEF: as it stands in the image; ORB: by its own grey values
};

template <>
inline constexpr auto kEnumNames<PatchOrientation> = EnumNames("gravity", "image");

/// Options of MakeFeatureExtractor; only the group of the chosen kind matters.
struct FeatureOptions {
  FeatureKind kind = FeatureKind::kBrief;
  PatchOrientation orientation = PatchOrientation::kGravity;
  BriefOptions brief;
  OrbOptions orb;

  /// Violations of the chosen kind's options, one line each.
  std::vector<std::string> Validate() const;

  template <typename Visitor>
  void Visit(Visitor& v) {
    v("kind", kind);
    v("orientation", orientation);
    v("brief", brief);
    v("orb", orb);
  }
};

/// Tells descriptors apart that can't be compared: "brief" or "orb" with PatchOrientation::kImage,
/// "brief@gravity" or "orb@gravity".
std::string DescriptorKind(const FeatureOptions& options);

}  // namespace deja_view
