#pragma once

#include "deja_view/camera/camera.hpp"
#include "deja_view/features/types.hpp"
#include "deja_view/geometry/rigid3.hpp"
#include "deja_view/verification/reject_reason.hpp"
#include "deja_view/verification/relative_pose.hpp"

#include <cstdint>
#include <memory>
#include <optional>
#include <string>
#include <vector>

#include <Eigen/Core>

namespace deja_view {

/// What verification needs of a keyframe: the corners of its image and the points that the VIO
/// tracked in it. Single precision: 1 mm at 100 m, 1e-4 px.
struct KeyframeFeatures {
  Rigid3 T_B_C;
  std::vector<Eigen::Vector2f> keypoints;     ///< [px]
  std::vector<Descriptor> descriptors;        ///< of the keypoints
  std::vector<Eigen::Vector3f> points_B;      ///< [m] tracked points in the body frame
  std::vector<Eigen::Vector2f> point_pixels;  ///< [px] where the VIO tracked them
  std::vector<float> point_depth_sigmas;      ///< [m] along the camera's ray
  std::vector<std::int64_t> point_ids;        ///< the VIO's feature ids
  std::vector<Descriptor> point_descriptors;  ///< described at point_pixels

  std::size_t MemoryBytes() const;
};

struct LoopVerifierOptions {
  RelativePoseOptions pose;
  // First matching, over the whole image.
  int max_distance = 80;   ///< [bits] of 256
  double max_ratio = 0.9;  ///< nearest over second nearest distance
  int min_matches = 10;
  int min_ransac_inliers = 8;
  // Guided matching around the reprojection.
  double guided_radius_px = 12.0;  ///< around the first pose
  double final_radius_px = 6.0;    ///< around the pose refined from these
  int guided_max_distance = 80;    ///< [bits]
  // Gates.
  int min_inliers = 25;
  double min_inlier_ratio = 0.2;  ///< of the points that fall into the other image
  int min_cells = 6;              ///< of an 8 x 6 grid on each image that inliers must occupy
  double max_distance_m = 6.0;
  double max_yaw_deg = 90.0;
  double max_gravity_deg = 3.0;
  double max_sigma_m = 0.1;  ///< largest standard deviation of the position

  template <typename Visitor>
  void Visit(Visitor& v) {
    v("pose", pose);
    v("max_distance", max_distance);
    v("max_ratio", max_ratio);
    v("min_matches", min_matches);
    v("min_ransac_inliers", min_ransac_inliers);
    v("guided_radius_px", guided_radius_px);
    v("final_radius_px", final_radius_px);
    v("guided_max_distance", guided_max_distance);
    v("min_inliers", min_inliers);
    v("min_inlier_ratio", min_inlier_ratio);
    v("min_cells", min_cells);
    v("max_distance_m", max_distance_m);
    v("max_yaw_deg", max_yaw_deg);
    v("max_gravity_deg", max_gravity_deg);
    v("max_sigma_m", max_sigma_m);
  }
  std::vector<std::string> Validate() const;
};

/// A current point found in the old image.
struct PointMatch {
  int point = -1;     ///< index into the current keyframe's points
  int keypoint = -1;  ///< index into the old keyframe's keypoints
};

/// Outcome for one candidate pair; the pose is meaningful from kPoorSpread on.
struct Verification {
  RejectReason reason = RejectReason::kTooFewMatches;
  Rigid3 T_Bold_Bcurrent;
  Eigen::Matrix<double, 6, 6> covariance = Eigen::Matrix<double, 6, 6>::Zero();
  int matches = 0;  ///< of the first matching, both directions
  int ransac_inliers = 0;
  int guided = 0;  ///< observations of the guided matching
  int inliers = 0;
  int visible = 0;  ///< points of either keyframe that fall into the other's image
  double rmse_px = 0;
  double gravity_disagreement = 0;        ///< [rad] before VIO's tilt enters as a prior
  int cells = 0;                          ///< the fewer of the two images' occupied cells
  std::vector<PointMatch> point_matches;  ///< inliers in the direction current point -> old image
};

/// Decides whether two keyframes show the same place and measures their relative pose: the current
/// keyframe's points against the old image and the old keyframe's points against the current image,
/// in one pose problem. Two-point RANSAC with known gravity, a guided second matching, robust
/// refinement with covariance, gates (method: "from candidate to constraint"). Deterministic and
/// thread-safe.
class LoopVerifier {
 public:
  LoopVerifier(const LoopVerifierOptions& options, std::shared_ptr<const Camera> camera);

  /// `q_W_Bold`, `q_W_Bcurrent`: VIO's orientations, of which only roll and pitch are used.
  Verification Verify(const KeyframeFeatures& current,
                      const Eigen::Quaterniond& q_W_Bcurrent,
                      const KeyframeFeatures& old,
                      const Eigen::Quaterniond& q_W_Bold) const;

  const LoopVerifierOptions& options() const { return options_; }

 private:
  struct Match;
  struct Problem;

  std::vector<Match> MatchAll(const KeyframeFeatures& points, const KeyframeFeatures& image) const;
  std::vector<Match> MatchGuided(const KeyframeFeatures& points,
                                 const KeyframeFeatures& image,
                                 const Rigid3& T_image_points,
                                 double radius_px,
                                 int* visible) const;
  void MatchBothWays(const KeyframeFeatures& current,
                     const KeyframeFeatures& old,
                     const Rigid3& T_old_current,
                     double radius_px,
                     Problem* problem,
                     int* visible) const;
  void AddObservations(const std::vector<Match>& matches,
                       const KeyframeFeatures& points,
                       const KeyframeFeatures& image,
                       bool is_reverse,
                       Problem* problem) const;
  /// Pose from matches over the whole image; sets `v->reason` where it returns nothing.
  std::optional<Rigid3> FirstPose(const KeyframeFeatures& current,
                                  const KeyframeFeatures& old,
                                  const GravityPair& gravity,
                                  Verification* v) const;
  void Summarise(const KeyframeFeatures& current,
                 const KeyframeFeatures& old,
                 const Problem& problem,
                 const RefinedPose& pose,
                 Verification* v) const;
  RejectReason Gate(const Verification& v) const;

  LoopVerifierOptions options_;
  std::shared_ptr<const Camera> camera_;
};

}  // namespace deja_view
