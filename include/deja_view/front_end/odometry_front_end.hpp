#pragma once

#include "deja_view/camera/camera.hpp"
#include "deja_view/front_end/corner_tracker.hpp"
#include "deja_view/front_end/image_queue.hpp"
#include "deja_view/front_end/track_triangulation.hpp"
#include "deja_view/geometry/rigid3.hpp"
#include "deja_view/host/image_source.hpp"
#include "deja_view/host/keyframe_input.hpp"
#include "deja_view/host/odometry_input.hpp"
#include "deja_view/host/world_level.hpp"

#include <cstdint>
#include <deque>
#include <functional>
#include <memory>
#include <optional>
#include <string>
#include <vector>

namespace deja_view {

/// How keyframes are made of images and an odometry's poses.
struct OdometryFrontEndOptions {
  double min_motion_px = 10;     ///< median, of corners since the keyframe before
  double min_interval_s = 0.09;  ///< between keyframes
  double window_s = 1.0;         ///< before a keyframe, of images that its points are seen in
  double delay_s = 0.25;         ///< after it, of the same
  double max_pose_gap_s = 0.2;   ///< between the poses that an image's is interpolated from
  double sequence_gap_s = 1.0;   ///< without an image: nothing is followed across
  double image_memory_mb = 300;  ///< of images that wait for their pose
  CornerTrackerOptions tracker;
  TrackTriangulationOptions points;

  template <typename Visitor>
  void Visit(Visitor& v) {
    v("min_motion_px", min_motion_px);
    v("min_interval_s", min_interval_s);
    v("window_s", window_s);
    v("delay_s", delay_s);
    v("max_pose_gap_s", max_pose_gap_s);
    v("sequence_gap_s", sequence_gap_s);
    v("image_memory_mb", image_memory_mb);
    v("tracker", tracker);
    v("points", points);
  }
  std::vector<std::string> Validate() const;
};

/// A camera beside the first one that films at the same moments.
struct SecondCamera {
  std::shared_ptr<const Camera> camera;
  Rigid3 T_B_C;
};

struct FrontEndSetup {
  OdometryFrontEndOptions options;
  std::shared_ptr<const Camera> camera;
  Rigid3 T_B_C;
  GravityPolicy gravity = GravityPolicy::kGiven;
  std::optional<SecondCamera> second = std::nullopt;
};

/// What came and what became of it.
struct FrontEndCounts {
  std::int64_t images = 0;
  std::int64_t poses = 0;
  std::int64_t keyframes = 0;
  std::int64_t points = 0;          ///< of these
  std::int64_t without_points = 0;  ///< of these, those that have none
  std::int64_t without_pose = 0;    ///< images before the first pose, or within a gap of the poses
  std::int64_t bad_images = 0;      ///< that can't be decoded, or of another size than the camera's
  std::int64_t stray_stamps = 0;    ///< images or poses whose stamp goes back
  std::int64_t overflows = 0;       ///< images given up because too many waited for a pose
};

/// The front end of a visual odometry for hosts that give nothing but poses: follows corners
/// through the images, chooses keyframes by how far the corners moved, and triangulates each
/// keyframe's corners from the poses of the images around it. What comes out depends only on the
/// images and the poses, each in their own order, and not on how the two interleave (as long as
/// nothing overflows). Poses whose stamps go back twice in a row are a new start.
///
/// With a second camera a keyframe's corners are looked for in its image of the same moment as
/// well, so that images far apart in time have points, too; images then wait for it.
///
/// With GravityPolicy::kEstimate keyframes wait until the world can be levelled, and are in the
/// level world.
///
/// Images are followed only while the poses are known; the work is done in whichever Add completes
/// it. Not thread-safe.
class OdometryFrontEnd {
 public:
  struct Keyframe {
    std::int64_t stamp_ns = 0;
    Rigid3 T_W_B;                      ///< interpolated to the image's stamp; W is level
    std::vector<TrackedPoint> points;  ///< triangulated; pixels are the distorted image's
  };
  using KeyframeCallback = std::function<void(Keyframe)>;
  using ProblemCallback = std::function<void(const std::string& what)>;

  /// Throws InputError for bad options.
  OdometryFrontEnd(const FrontEndSetup& setup,
                   KeyframeCallback on_keyframe,
                   ProblemCallback on_problem);

  /// `bytes` is what the source holds in memory. This and AddPose throw UnusableFlight for a world
  /// that is not level.
  void AddImage(std::int64_t stamp_ns, ImageSource image, std::size_t bytes);
  void AddPose(std::int64_t stamp_ns, const Rigid3& T_W_B);
  /// Of the second camera, which there must be: of the first one's stamps, to a millisecond.
  void AddSecondImage(std::int64_t stamp_ns, ImageSource image, std::size_t bytes);

  /// End of the stream: keyframes no longer wait for images to come.
  void Flush();

  const FrontEndCounts& counts() const { return counts_; }

  /// From the odometry's world to that of the keyframes; the identity until it is known.
  Rigid3 T_L_W() const { return level_.T_L_W().value_or(Rigid3::Identity()); }

 private:
  /// A corner in the second camera's image.
  struct SecondRay {
    std::size_t corner = 0;
    Eigen::Vector3d ray_W;
  };
  struct Frame {
    std::int64_t stamp_ns = 0;
    Rigid3 T_W_B;
    TrackedCorners corners;
    std::vector<Eigen::Vector3d> rays_W;  ///< of the corners
    std::vector<SecondRay> second_rays;   ///< of a keyframe
    bool is_keyframe = false;
    bool is_handed_over = false;
    StampedPose pose() const { return {stamp_ns, T_W_B}; }
  };

  void Restart(const StampedPose& first);
  void Wait(WaitingImage image, ImageQueue* queue);
  bool IsComplete(std::int64_t stamp_ns) const;
  void FollowWaiting();
  std::optional<Rigid3> PoseAt(std::int64_t stamp_ns) const;
  void Follow(const WaitingImage& waiting, const Rigid3& T_W_B);
  std::optional<cv::Mat> Decode(const WaitingImage& waiting, const Camera& camera);
  std::vector<SecondRay> FindSecondRays(const Frame& frame);
  bool IsKeyframe(const Frame& frame) const;
  void HandOver(bool is_end);
  void HandOverLevel();
  void GiveUpUnlevelled();
  Keyframe MakeKeyframe(const Frame& frame) const;
  void Prune();
  void Tell(const std::string& what) const;

  OdometryFrontEndOptions options_;
  std::shared_ptr<const Camera> camera_;
  Rigid3 T_B_C_;
  std::optional<SecondCamera> second_;
  KeyframeCallback on_keyframe_;
  ProblemCallback on_problem_;
  FrontEndCounts counts_;

  GravityPolicy gravity_;
  WorldLevel level_;
  std::vector<Keyframe> unlevelled_;  ///< that wait until the level is known
  CornerTracker tracker_;
  ImageQueue waiting_;
  ImageQueue waiting_second_;
  bool is_ended_ = false;               ///< no second image comes any more
  std::deque<StampedPose> poses_;       ///< T_W_B
  std::optional<StampedPose> suspect_;  ///< pose whose stamp went back
  std::deque<Frame> frames_;            ///< that keyframes not handed over, or to come, look at
  std::optional<Frame> last_keyframe_;
};

}  // namespace deja_view
