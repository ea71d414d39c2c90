#pragma once

#include "deja_view/camera/camera.hpp"
#include "deja_view/geometry/rigid3.hpp"
#include "deja_view/triangulation/corner_depths.hpp"

#include <deque>
#include <memory>
#include <string>
#include <vector>

namespace deja_view {

/// Which images of the past a new one is triangulated with, and how far their relative pose is
/// believed.
struct MotionStereoOptions {
  int recent = 20;                          ///< images kept; 0: nothing is triangulated
  int partners = 3;                         ///< of them, those that a new image is matched with
  double min_overlap = 0.4;                 ///< of the new image's view that a partner must see
  double min_depth_ratio = 0.2;             ///< to the scene's median: nothing nearer is looked for
  int enough = 100;                         ///< tracked points: an image with so many needs no more
  int max_points = 120;                     ///< best of an image's corners that become points
  double min_distance_px = 4.0;             ///< of them from those that are points already
  double position_sigma_per_sqrt_m = 0.01;  ///< of the odometry, per square root of the metres
  double yaw_sigma_per_sqrt_m_deg = 0.1;
  TriangulationOptions pair;

  template <typename Visitor>
  void Visit(Visitor& v) {
    v("recent", recent);
    v("partners", partners);
    v("min_overlap", min_overlap);
    v("min_depth_ratio", min_depth_ratio);
    v("enough", enough);
    v("max_points", max_points);
    v("min_distance_px", min_distance_px);
    v("position_sigma_per_sqrt_m", position_sigma_per_sqrt_m);
    v("yaw_sigma_per_sqrt_m_deg", yaw_sigma_per_sqrt_m_deg);
    v("pair", pair);
  }
  std::vector<std::string> Validate() const;
};

/// The corners of certain depth, the best first, at most `options.max_points` of them and none near
/// a pixel of `taken`: several images that agree count before one alone, then by relative
/// deviation.
std::vector<std::size_t> SelectPoints(const CornerView& view,
                                      const std::vector<Eigen::Vector2f>& taken,
                                      const Camera& camera,
                                      const MotionStereoOptions& options);

/// Depths of an image sequence's corners from the motion between the images. Deterministic.
class MotionStereo {
 public:
  MotionStereo(const MotionStereoOptions& options, std::shared_ptr<const Camera> camera);

  /// Forgets all images: those to come have poses in another world.
  void Restart() { recent_.clear(); }

  /// An image of the sequence.
  struct Image {
    int id = -1;
    Rigid3 T_W_C;
    CornerView view;
    int wanted = 0;  ///< partners; none with enough tracked points
  };

  /// Adds the next image and, unless it has `enough` tracked points, matches it with some of the
  /// recent ones and fuses what that says of both sides' depths. An image that lacked partners in
  /// its past, as the first one does, gets them from those to come, also when these have enough.
  /// Returns the images whose depths may have changed, the new one first; valid until the next
  /// call. `depth_m`: how far away the scene is, where nothing else is known.
  std::vector<const Image*> Add(
      int id, const Rigid3& T_W_C, CornerView view, std::size_t tracked, double depth_m);

 private:
  struct Partner {
    std::size_t index;  ///< in recent_
    double parallax;    ///< baseline over depth
  };
  std::vector<Partner> ChoosePartners(const Image& image, double depth_m) const;
  double Overlap(const Rigid3& T_b_a, double depth_m) const;
  double MedianDepth(double otherwise) const;

  MotionStereoOptions options_;
  std::shared_ptr<const Camera> camera_;
  std::vector<Eigen::Vector3d> probes_;  ///< rays through the image that overlap is counted on
  std::deque<Image> recent_;
};

}  // namespace deja_view
