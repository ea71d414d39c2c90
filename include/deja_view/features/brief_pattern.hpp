#pragma once

#include <array>
#include <cstdint>
#include <filesystem>

namespace deja_view {

/// Where BRIEF compares the smoothed image: bit i is set when the first point of pair i is darker
/// than the second.
struct BriefPattern {
  /// Offsets from the keypoint [px].
  struct Pair {
    std::int8_t x1 = 0;
    std::int8_t y1 = 0;
    std::int8_t x2 = 0;
    std::int8_t y2 = 0;

    friend bool operator==(const Pair& a, const Pair& b) {
      return a.x1 == b.x1 && a.y1 == b.y1 && a.x2 == b.x2 && a.y2 == b.y2;
    }
  };

  std::array<Pair, 256> pairs;

  /// Largest offset in any direction [px]: how far from the border every sample lies in the image.
  int Radius() const;
};

/// The package's own pattern: Gaussian of standard deviation 48/5 px cut to 48 x 48 (Calonder et
/// al., ECCV 2010). The same as config/brief_pattern.yml.
const BriefPattern& DefaultBriefPattern();

/// Reads a pattern in the layout of VINS-Mono's `brief_pattern.yml`: OpenCV YAML with four lists
/// x1, y1, x2, y2 of 256 integers in [-127, 127]. Throws InputError, naming file and key.
BriefPattern ReadBriefPattern(const std::filesystem::path& path);

}  // namespace deja_view
