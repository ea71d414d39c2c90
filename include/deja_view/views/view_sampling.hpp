#pragma once

#include "deja_view/base/enum_names.hpp"
#include "deja_view/geometry/rigid3.hpp"

#include <cstdint>
#include <functional>
#include <string>
#include <vector>

namespace deja_view {

/// What a new source image is compared with.
enum class SourceSpacing {
  kPrevious,  ///< the source before it: every stretch of the flight gets views
  kAll,       ///< all sources so far: a place gets views once, as a map of places does
};

template <>
inline constexpr auto kEnumNames<SourceSpacing> = EnumNames("previous", "all");

/// Which images get virtual views.
struct SourceOptions {
  double every_m = 0.02;  ///< an image nearer than this to another source
  double every_deg =
      0;  ///< and turned less than this against it gets none; 0: only distance counts
  SourceSpacing against = SourceSpacing::kPrevious;

  /// Violations, one line each.
  std::vector<std::string> Validate() const;

  template <typename Visitor>
  void Visit(Visitor& v) {
    v("every_m", every_m);
    v("every_deg", every_deg);
    v("against", against);
  }
};

/// Where virtual cameras are, around a source image's (Sec. 3.2.2).
struct SamplingOptions {
  int views = 3;                 ///< per source image at most
  double radius_m = 0.02;        ///< of the ball about the real camera
  double min_radius_m = 0;       ///< nearest that a virtual camera may be to the real one
  double spacing_min_m = 0.005;  ///< lambda_min: distance of a view to its nearest neighbour
  double spacing_max_m = 0.03;   ///< lambda_max
  double rotation_deg = 2;  ///< theta: components of the rotation vector lie in [-theta/2, theta/2]
  int candidates = 64;      ///< points drawn per ball
  std::uint64_t seed = 1;

  /// Violations, one line each.
  std::vector<std::string> Validate() const;

  template <typename Visitor>
  void Visit(Visitor& v) {
    v("views", views);
    v("radius_m", radius_m);
    v("min_radius_m", min_radius_m);
    v("spacing_min_m", spacing_min_m);
    v("spacing_max_m", spacing_max_m);
    v("rotation_deg", rotation_deg);
    v("candidates", candidates);
    v("seed", seed);
  }
};

/// Decides image by image which get views.
class SourceSelector {
 public:
  explicit SourceSelector(const SourceOptions& options) : options_(options) {}

  /// Whether the image at this pose is far enough from its predecessors; it is then one of them.
  bool Take(const Rigid3& T_N_C);

 private:
  SourceOptions options_;
  std::vector<Rigid3> taken_;
};

/// Indices of the images that get views, in order: the first, and each that has moved or turned far
/// enough ("no views for a source closer than 2 cm to the previous one", Sec. 3.2.2).
std::vector<std::size_t> SelectSources(const std::vector<Rigid3>& T_N_C,
                                       const SourceOptions& options);

/// Poses T_C_V of the virtual cameras of one image [m]; they depend only on the options and the
/// image's stamp. Points are drawn evenly in the ball and thinned with a KD-tree until none
/// is nearer than spacing_min_m to its neighbour; of these, in the order of drawing, each is taken
/// that `accept`s and lies at most spacing_max_m from one taken before (the first always does).
/// Rotations are exp([w]x), drawn after the positions and multiplied from the right: the paper's
/// noise on the elements of R, as corrected, stays in SO(3).
///
/// With two views or more, the distance of each to its nearest neighbour lies in [spacing_min_m,
/// spacing_max_m]. `accept` may be empty: every pose does.
std::vector<Rigid3> SampleViews(const SamplingOptions& options,
                                std::int64_t stamp_ns,
                                const std::function<bool(const Rigid3& T_C_V)>& accept);

}  // namespace deja_view
