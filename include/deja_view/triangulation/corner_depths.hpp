#pragma once

#include "deja_view/camera/camera.hpp"
#include "deja_view/features/types.hpp"
#include "deja_view/geometry/rigid3.hpp"

#include <cstdint>
#include <string>
#include <vector>

#include <Eigen/Core>

namespace deja_view {

/// How corners of two images of known relative pose are matched and triangulated.
struct TriangulationOptions {
  double min_depth_m = 0.3;  ///< along a corner's ray
  double max_depth_m = 60.0;
  double band_px = 2.0;    ///< from the epipolar curve, beyond what the pose's noise explains
  int max_distance = 60;   ///< [bit] of 256 between the two descriptors
  double max_ratio = 0.8;  ///< nearest over second nearest distance along the curve
  double pixel_sigma = 0.7;
  double max_sigma_ratio = 0.15;  ///< of a depth's deviation to the depth; above, it is none yet
  double sigma_floor = 0.02;      ///< of the same ratio

  template <typename Visitor>
  void Visit(Visitor& v) {
    v("min_depth_m", min_depth_m);
    v("max_depth_m", max_depth_m);
    v("band_px", band_px);
    v("max_distance", max_distance);
    v("max_ratio", max_ratio);
    v("pixel_sigma", pixel_sigma);
    v("max_sigma_ratio", max_sigma_ratio);
    v("sigma_floor", sigma_floor);
  }
  std::vector<std::string> Validate() const;
};

/// What is known of the distance to what a corner shows, along its unit ray. Gaussian in the
/// inverse, as pixels are.
struct InverseDepth {
  float mean = 0;            ///< [1/m]
  float sigma = 0;           ///< [1/m]; 0: nothing is known
  std::int32_t matches = 0;  ///< other images that say so

  bool is_known() const { return sigma > 0; }
};

/// The corners of an image, and what is known of their depths: vectors of one length.
struct CornerView {
  std::vector<Eigen::Vector2f> pixels;
  std::vector<Descriptor> descriptors;
  std::vector<Eigen::Vector3f> rays;  ///< unit vectors in C
  std::vector<InverseDepth> depths;
};

/// Unprojects the corners; their depths are unknown.
CornerView MakeCornerView(const std::vector<Eigen::Vector2f>& pixels,
                          const std::vector<Descriptor>& descriptors,
                          const Camera& camera);

/// Standard deviations of a relative pose.
struct PoseNoise {
  double position_m = 0;
  double rotation_rad = 0;
};

/// Looks for the corners of `a` along their epipolar curves in `b`, as far as their depth may be,
/// and takes those pairs of corners that are each other's best. What the pair says of the depths
/// is fused into both views; a corner of `a` of which nothing was known takes over what `b` knew.
/// Pairs that contradict what is known are left out. Returns the number of pairs. Inverse depth
/// filters of corners matched over the epipolar line are those of semi-direct odometries (Forster
/// et al., ICRA 2014), here on descriptors instead of patches.
int TriangulatePair(const Rigid3& T_b_a,
                    const PoseNoise& noise,
                    const Camera& camera,
                    const TriangulationOptions& options,
                    CornerView* a,
                    CornerView* b);

/// True when the depth is certain enough to make a point of the corner.
bool IsCertain(const InverseDepth& depth, const TriangulationOptions& options);

}  // namespace deja_view
