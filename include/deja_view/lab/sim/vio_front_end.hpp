#pragma once

#include "deja_view/camera/camera.hpp"
#include "deja_view/geometry/rigid3.hpp"
#include "deja_view/host/keyframe_input.hpp"
#include "deja_view/lab/sim/options.hpp"
#include "deja_view/lab/sim/random.hpp"
#include "deja_view/lab/sim/world.hpp"

#include <cstdint>
#include <deque>
#include <memory>
#include <optional>
#include <vector>

#include <Eigen/Core>
#include <opencv2/core/mat.hpp>

namespace deja_view::sim {

/// One camera frame, with what the odometry believes and what is true.
struct VioFrame {
  std::int64_t stamp_ns = 0;
  Rigid3 T_W_B;   ///< truth
  Rigid3 T_V_B;   ///< the odometry's estimate, in its own world V
  cv::Mat image;  ///< CV_8UC1
};

/// Stands for VINS-Mono's feature_tracker and estimator: corners of the real image are tracked by
/// projecting the point of the hall that they show, with noise, outliers, occlusion and losses, and
/// triangulated with the uncertainty that their baseline gives.
class VioFrontEnd {
 public:
  VioFrontEnd(std::shared_ptr<const World> world,
              std::shared_ptr<const Camera> camera,
              const Rigid3& T_B_C,
              const VioOptions& options,
              std::uint64_t seed);

  /// Tracks into the next frame; returns a keyframe when the view has changed enough since the last
  /// one. Points of the keyframe are in V.
  std::optional<KeyframeInput> Process(const VioFrame& frame);

  int track_count() const { return static_cast<int>(tracks_.size()); }

  /// Point of the hall [m] that a track shows; nothing when it is not tracked, or is an outlier.
  std::optional<Eigen::Vector3d> TruePoint(std::int64_t feature_id) const;

 private:
  struct Observation {
    Rigid3 T_V_C;
    Eigen::Vector3d t_W_C;
    Eigen::Vector2d pixel;
  };
  struct Track {
    std::int64_t id = 0;
    Eigen::Vector3d p_W;
    std::deque<Observation> window;  ///< oldest first, as long as VINS-Mono's sliding window
    int age = 0;                     ///< frames
    bool in_keyframe = false;        ///< seen in the last keyframe, at keyframe_pixel
    Eigen::Vector2d keyframe_pixel = Eigen::Vector2d::Zero();
    double depth_error = 0;  ///< standard normal, of the whole track
    bool is_outlier = false;
    double outlier_depth = 1;                         ///< factor on its range
    Eigen::Vector2d slide = Eigen::Vector2d::Zero();  ///< [px/frame] of an outlier
  };

  bool Follow(const Rigid3& T_W_C, const Rigid3& T_V_C, Track* track);
  bool IsVisible(const Eigen::Vector3d& camera_W, const Eigen::Vector3d& p_W) const;
  void AddCorners(const cv::Mat& image, const Rigid3& T_W_C, const Rigid3& T_V_C);
  void AddTrack(const Eigen::Vector2d& pixel, const Rigid3& T_W_C, const Rigid3& T_V_C);
  bool IsKeyframe() const;
  std::optional<TrackedPoint> Triangulate(const Track& track) const;

  std::shared_ptr<const World> world_;
  std::shared_ptr<const Camera> camera_;
  Rigid3 T_B_C_;
  VioOptions options_;
  Rng rng_;
  double min_distance_px_;
  std::int64_t next_id_ = 0;
  bool has_keyframe_ = false;
  std::vector<Track> tracks_;
};

}  // namespace deja_view::sim
