#pragma once

#include "deja_view/camera/camera.hpp"
#include "deja_view/features/types.hpp"
#include "deja_view/geometry/rigid3.hpp"
#include "deja_view/verification/keyframe_features.hpp"
#include "deja_view/verification/reject_reason.hpp"
#include "deja_view/verification/relative_pose.hpp"

#include <cstdint>
#include <memory>
#include <optional>
#include <string>
#include <vector>

#include <Eigen/Core>

namespace deja_view {
namespace internal {

struct LoopLink;
struct LoopMatch;
struct LoopPair;
struct LoopProblem;

}  // namespace internal

/// The scale of what a keyframe sees [m]: the median distance of its points from the camera; 0
/// without points.
double SceneDepth(const KeyframeFeatures& keyframe);

/// The share of `from`'s points that fall into the image of `to`, whose body sees them from
/// `T_to_from`; 0 without points.
double OverlapShare(const KeyframeFeatures& from,
                    const KeyframeFeatures& to,
                    const Rigid3& T_to_from,
                    const Camera& camera);

/// A virtual camera in the rig of an old keyframe: `features.T_B_C` is T_B_V, its points are those
/// keypoints whose depth is certain.
struct RigCamera {
  KeyframeFeatures features;
  std::shared_ptr<const Camera> camera;
  int number = 0;  ///< among all virtual cameras of its keyframe, whichever are in the rig
};

/// Gates for loops that the real image alone does not give. What several cameras of the rig show
/// counts once.
struct RigGates {
  /// Of all first matches that must agree in RANSAC, beside min_ransac_inliers: of the many matches
  /// of several images, more agree by chance.
  double min_ransac_ratio = 0.03;
  double max_log10_false_alarms = -3.0;
  double min_inlier_ratio = 0.25;  ///< of the current points that fall into any camera of the rig
  double max_gravity_deg = 2.0;
  double max_sigma_over_depth = 0.03;  ///< of the position, over the scene's depth

  template <typename Visitor>
  void Visit(Visitor& v) {
    v("min_ransac_ratio", min_ransac_ratio);
    v("max_log10_false_alarms", max_log10_false_alarms);
    v("min_inlier_ratio", min_inlier_ratio);
    v("max_gravity_deg", max_gravity_deg);
    v("max_sigma_over_depth", max_sigma_over_depth);
  }
  std::vector<std::string> Validate() const;
};

struct LoopVerifierOptions {
  RelativePoseOptions pose;
  // First matching, over the whole image.
  int max_distance = 80;   ///< [bits] of 256
  double max_ratio = 0.9;  ///< nearest over second nearest distance
  int min_matches = 5;
  int min_ransac_inliers = 5;
  // Guided matching around the reprojection.
  double predicted_radius_px = 32.0;  ///< around a predicted pose, tried where RANSAC's fails
  double guided_radius_px = 12.0;     ///< around the first pose
  double final_radius_px = 6.0;       ///< around the pose refined from these
  int guided_max_distance = 80;       ///< [bits]
  // Gates. Chance explains what a wrong pose finds, the ratio what a copy of a part of the scene
  // shows: the rest of it is not where it should be.
  double max_log10_false_alarms = -2.0;
  double min_inlier_ratio = 0.2;          ///< of the points that fall into the other image
  double max_distance_over_depth = 1.25;  ///< between the two bodies, over the scene's depth
  double max_yaw_deg = 90.0;
  double max_gravity_deg = 3.0;
  // Largest standard deviation of the position: over the scene's depth, for what a scene can tell;
  // and in metres, with a rig as well, for what a loop is to be good for.
  double max_sigma_over_depth = 0.03;
  double max_sigma_m = 0.08;
  RigGates rig;  ///< in place of these where virtual views are needed

  template <typename Visitor>
  void Visit(Visitor& v) {
    v("pose", pose);
    v("max_distance", max_distance);
    v("max_ratio", max_ratio);
    v("min_matches", min_matches);
    v("min_ransac_inliers", min_ransac_inliers);
    v("predicted_radius_px", predicted_radius_px);
    v("guided_radius_px", guided_radius_px);
    v("final_radius_px", final_radius_px);
    v("guided_max_distance", guided_max_distance);
    v("max_log10_false_alarms", max_log10_false_alarms);
    v("min_inlier_ratio", min_inlier_ratio);
    v("max_distance_over_depth", max_distance_over_depth);
    v("max_yaw_deg", max_yaw_deg);
    v("max_gravity_deg", max_gravity_deg);
    v("max_sigma_over_depth", max_sigma_over_depth);
    v("max_sigma_m", max_sigma_m);
    v("rig", rig);
  }
  std::vector<std::string> Validate() const;
};

/// A current point found in the old image.
struct PointMatch {
  int point = -1;     ///< index into the current keyframe's points
  int keypoint = -1;  ///< index into the old keyframe's keypoints
};

/// An inlier as pixels, to show it.
struct PixelMatch {
  static constexpr int kRealCamera = -1;
  int camera = kRealCamera;  ///< of the old keyframe: the number of a virtual one, or the real one
  Eigen::Vector2f old_pixel = Eigen::Vector2f::Zero();
  Eigen::Vector2f current_pixel = Eigen::Vector2f::Zero();
};

/// How well a virtual view and its own source image show the same.
struct Agreement {
  int visible = 0;  ///< points of either that should be in the other's image
  int found = 0;    ///< of those, the ones that are
};

/// Outcome for one candidate pair; the pose is meaningful from kByChance on.
struct Verification {
  RejectReason reason = RejectReason::kTooFewMatches;
  Rigid3 T_Bold_Bcurrent;
  Eigen::Matrix<double, 6, 6> covariance = Eigen::Matrix<double, 6, 6>::Zero();
  int matches = 0;  ///< of the first matching, both directions
  int ransac_inliers = 0;
  int guided = 0;  ///< observations of the guided matching
  int inliers = 0;
  int visible = 0;  ///< points of either keyframe that fall into the other's image
  int found = 0;    ///< of those, the inliers; with a rig only current points, each once
  double rmse_px = 0;
  double gravity_disagreement = 0;  ///< [rad] before VIO's tilt enters as a prior
  /// Of the expected number of poses, among all that were tried, that would find as much by chance:
  /// see ChanceOfSupport.
  double log10_false_alarms = 0;
  double scene_depth = 0;                 ///< [m] median distance of the inliers' points
  std::vector<PointMatch> point_matches;  ///< inliers in the direction current point -> old image
  std::vector<PixelMatch> pixel_matches;  ///< all inliers
};

/// One of the conditions that a loop has to meet, in their order.
struct GateReading {
  RejectReason reason = RejectReason::kNone;  ///< what a loop is refused for that does not meet it
  std::string option;                         ///< key under `verification` in the options
  double value = 0;
  double limit = 0;
  bool is_at_least = false;  ///< passes from the limit on, or else up to it

  bool passes() const { return is_at_least ? value >= limit : value <= limit; }
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
  /// `T_Bold_Bcurrent_predicted`, where something is known of it, is the guided matching's second
  /// start: few matches over the whole image are right where the viewpoint differs much, more
  /// within a window. Few poses are tried about it, so that fewer inliers are improbable.
  Verification Verify(const KeyframeFeatures& current,
                      const Eigen::Quaterniond& q_W_Bcurrent,
                      const KeyframeFeatures& old,
                      const Eigen::Quaterniond& q_W_Bold,
                      const std::optional<Rigid3>& T_Bold_Bcurrent_predicted = {}) const;

  /// The same with `virtual_cameras` added to the old keyframe: one rigid rig, one generalised pose
  /// problem in which every camera's matches count alike. For pairs that the real image does not
  /// join; gated by `rig`. The two-point solver takes each observation with its own camera's
  /// centre, so that a rig of any number of cameras needs no other solver.
  Verification VerifyRig(const KeyframeFeatures& current,
                         const Eigen::Quaterniond& q_W_Bcurrent,
                         const KeyframeFeatures& old,
                         const Eigen::Quaterniond& q_W_Bold,
                         const std::vector<RigCamera>& virtual_cameras,
                         const std::optional<Rigid3>& T_Bold_Bcurrent_predicted = {}) const;

  /// All conditions for a pose that was found (`inliers` > 0) by Verify, or with `with_rig` by
  /// VerifyRig. The first one that does not pass is what `v` was refused for.
  std::vector<GateReading> Readings(const Verification& v, bool with_rig) const;

  /// The first matching, over whole images: of the current points in the old image and the other
  /// way round.
  std::vector<PixelMatch> FirstMatches(const KeyframeFeatures& current,
                                       const KeyframeFeatures& old) const;

  /// Looks for the points of a virtual camera in the real image of the same body, and the other way
  /// round.
  Agreement Agree(const RigCamera& virtual_camera, const KeyframeFeatures& source) const;

  const LoopVerifierOptions& options() const { return options_; }

 private:
  using Link = internal::LoopLink;
  using Match = internal::LoopMatch;
  using Problem = internal::LoopProblem;
  using Pair = internal::LoopPair;

  std::vector<Match> MatchAll(const Link& link) const;
  std::vector<Match> MatchGuided(const Link& link,
                                 const Rigid3& T_image_points,
                                 double radius_px,
                                 std::vector<bool>* visible) const;
  Problem MatchAround(const Pair& pair, const Rigid3& T_old_current, double radius_px) const;
  void AddObservations(const Link& link,
                       std::size_t index,
                       const std::vector<Match>& matches,
                       Problem* problem) const;
  RigGates GatesOf(bool has_rig) const;
  /// Pose from matches over whole images; sets `v->reason` where it returns nothing.
  std::optional<Rigid3> FirstPose(const Pair& pair, Verification* v) const;
  /// Guided matching from a first pose, for which `log10_tests` poses were tried, through all
  /// gates.
  void SolveFrom(const Rigid3& first,
                 const std::vector<double>& radii_px,
                 double log10_tests,
                 const Pair& pair,
                 Verification* v) const;
  Verification Solve(const Pair& pair, const std::optional<Rigid3>& predicted) const;
  void Summarise(const Pair& pair,
                 const Problem& problem,
                 const RefinedPose& pose,
                 Verification* v) const;
  void CountOnce(const Pair& pair,
                 const Problem& problem,
                 const RefinedPose& pose,
                 Verification* v) const;
  /// Matches per cell of the current image that has any.
  double Crowding(const std::vector<PixelMatch>& matches) const;
  double Log10FalseAlarms(const Pair& pair,
                          const Problem& problem,
                          const RefinedPose& pose,
                          double log10_tests) const;
  RejectReason Gate(const Verification& v, bool has_rig) const;

  LoopVerifierOptions options_;
  std::shared_ptr<const Camera> camera_;
};

}  // namespace deja_view
