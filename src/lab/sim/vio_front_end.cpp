#include "deja_view/lab/sim/vio_front_end.hpp"

#include "deja_view/base/check.hpp"
#include "deja_view/lab/sim/scene.hpp"

#include <algorithm>
#include <cmath>
#include <utility>

#include <opencv2/imgproc.hpp>

namespace deja_view::sim {
namespace {

constexpr std::uint64_t kFrontEndStream = 60;
constexpr std::size_t kWindow = 10;      // frames, VINS-Mono's sliding window
constexpr int kLeastAge = 3;             // frames before a point is triangulated
constexpr double kLossPerFrame = 0.005;  // tracks that are lost for no visible reason
constexpr double kLeastBaseline = 0.03;  // [m] across the line of sight
constexpr double kMostUncertain = 0.25;  // standard deviation of the depth over the depth
constexpr double kCornerQuality = 0.01;  // of the best corner's score
constexpr int kFewTracks = 20;           // below, every frame is a keyframe

}  // namespace

VioFrontEnd::VioFrontEnd(std::shared_ptr<const World> world,
                         std::shared_ptr<const Camera> camera,
                         const Rigid3& T_B_C,
                         const VioOptions& options,
                         std::uint64_t seed)
    : world_(std::move(world)),
      camera_(std::move(camera)),
      T_B_C_(T_B_C),
      options_(options),
      rng_(seed, kFrontEndStream) {
  DEJA_VIEW_CHECK(world_ != nullptr && camera_ != nullptr);
  min_distance_px_ = std::max(2.0, options.min_distance_px * camera_->width() / 752.0);
}

bool VioFrontEnd::IsVisible(const Eigen::Vector3d& camera_W, const Eigen::Vector3d& p_W) const {
  const Eigen::Vector3d ray = p_W - camera_W;
  const double range = ray.norm();
  const auto hit = CastRay(world_->scene(), camera_W, ray / range);
  return hit && hit->range > 0.995 * range - 0.01;
}

bool VioFrontEnd::Follow(const Rigid3& T_W_C, const Rigid3& T_V_C, Track* track) {
  // Drawn for every track, so that one that is lost does not change the noise of the others.
  const double chance = rng_.Uniform();
  const double noise_x = rng_.Normal();
  const double noise_y = rng_.Normal();
  const auto projection = camera_->Project(T_W_C.Inverse() * track->p_W);
  if (!projection || chance < kLossPerFrame) {
    return false;
  }
  const Eigen::Vector2d pixel = *projection +
                                options_.pixel_noise_px * Eigen::Vector2d(noise_x, noise_y) +
                                track->age * track->slide;
  if (!camera_->IsInImage(pixel, 1.0) || !IsVisible(T_W_C.t, track->p_W)) {
    return false;
  }
  track->window.push_back({T_V_C, T_W_C.t, pixel});
  if (track->window.size() > kWindow) {
    track->window.pop_front();
  }
  ++track->age;
  return true;
}

void VioFrontEnd::AddTrack(const Eigen::Vector2d& pixel, const Rigid3& T_W_C, const Rigid3& T_V_C) {
  Track track;
  track.depth_error = rng_.Normal();
  track.is_outlier = rng_.Chance(options_.outlier_fraction);
  const double speed = rng_.Uniform(0.2, 0.8);
  const double heading = rng_.Uniform(0, 6.2831853);
  const double factor = rng_.Uniform(-0.5, 0.5);
  if (track.is_outlier) {
    track.slide = speed * Eigen::Vector2d(std::cos(heading), std::sin(heading));
    track.outlier_depth = std::exp(factor);
  }
  const Eigen::Vector3d direction = T_W_C.q * camera_->Unproject(pixel);
  const auto hit = CastRay(world_->scene(), T_W_C.t, direction);
  if (!hit) {
    return;
  }
  track.id = next_id_++;
  track.p_W = T_W_C.t + static_cast<double>(hit->range) * direction;
  track.window.push_back({T_V_C, T_W_C.t, pixel});
  track.age = 1;
  tracks_.push_back(std::move(track));
}

void VioFrontEnd::AddCorners(const cv::Mat& image, const Rigid3& T_W_C, const Rigid3& T_V_C) {
  const int wanted = options_.max_points - static_cast<int>(tracks_.size());
  if (wanted <= 0) {
    return;
  }
  cv::Mat mask(image.size(), CV_8UC1, cv::Scalar(255));
  for (const Track& track : tracks_) {
    const Eigen::Vector2d& pixel = track.window.back().pixel;
    cv::circle(mask,
               {static_cast<int>(std::lround(pixel.x())), static_cast<int>(std::lround(pixel.y()))},
               static_cast<int>(min_distance_px_),
               cv::Scalar(0),
               cv::FILLED);
  }
  std::vector<cv::Point2f> corners;
  cv::goodFeaturesToTrack(image, corners, wanted, kCornerQuality, min_distance_px_, mask);
  for (const cv::Point2f& corner : corners) {
    if (camera_->IsInImage({corner.x, corner.y}, 1.0)) {
      AddTrack({corner.x, corner.y}, T_W_C, T_V_C);
    }
  }
}

/// Mean shift of the tracks since the last keyframe, as in VINS-Mono without compensating rotation.
bool VioFrontEnd::IsKeyframe() const {
  double shift = 0;
  int common = 0;
  for (const Track& track : tracks_) {
    if (track.in_keyframe) {
      shift += (track.window.back().pixel - track.keyframe_pixel).norm();
      ++common;
    }
  }
  if (!has_keyframe_ || common < kFewTracks) {
    return true;
  }
  return shift / common >= options_.keyframe_parallax_px * camera_->FocalLength() / 460.0;
}

/// The point along the ray of the observation in the middle of the window, where the estimator,
/// which fits all of them, is nearest. Inverse range has the standard deviation sigma_px / (f b
/// sqrt(n / 2)), b being the baseline across the line of sight of n observations.
std::optional<TrackedPoint> VioFrontEnd::Triangulate(const Track& track) const {
  if (track.age < kLeastAge) {
    return std::nullopt;
  }
  const Observation& oldest = track.window.front();
  const Observation& newest = track.window.back();
  const Observation& anchor = track.window[track.window.size() / 2];
  const Eigen::Vector3d ray_W = track.p_W - anchor.t_W_C;
  const double range = ray_W.norm();
  const double baseline =
      std::max(kLeastBaseline, (ray_W / range).cross(newest.t_W_C - oldest.t_W_C).norm());
  const double observations = static_cast<double>(track.window.size());
  const double sigma = std::max(options_.pixel_noise_px, 0.05) /
                       (camera_->FocalLength() * baseline * std::sqrt(observations / 2.0));
  if (sigma * range > kMostUncertain) {
    return std::nullopt;
  }
  const double error = std::clamp(track.depth_error, -2.5, 2.5) * sigma;
  const double estimate = track.outlier_depth / (1.0 / range + error);
  TrackedPoint point;
  point.p_W = anchor.T_V_C * (estimate * camera_->Unproject(anchor.pixel));
  point.pixel = newest.pixel.cast<float>();
  point.feature_id = track.id;
  return point;
}

std::optional<KeyframeInput> VioFrontEnd::Process(const VioFrame& frame) {
  DEJA_VIEW_CHECK(frame.image.type() == CV_8UC1);
  DEJA_VIEW_CHECK(frame.image.cols == camera_->width() && frame.image.rows == camera_->height());
  const Rigid3 T_W_C = frame.T_W_B * T_B_C_;
  const Rigid3 T_V_C = frame.T_V_B * T_B_C_;
  std::vector<Track> followed;
  for (Track& track : tracks_) {
    if (Follow(T_W_C, T_V_C, &track)) {
      followed.push_back(std::move(track));
    }
  }
  tracks_ = std::move(followed);
  AddCorners(frame.image, T_W_C, T_V_C);
  if (!IsKeyframe()) {
    return std::nullopt;
  }
  has_keyframe_ = true;
  KeyframeInput keyframe;
  keyframe.stamp_ns = frame.stamp_ns;
  keyframe.T_W_B = frame.T_V_B;
  keyframe.image = frame.image;
  for (Track& track : tracks_) {
    track.in_keyframe = true;
    track.keyframe_pixel = track.window.back().pixel;
    if (const auto point = Triangulate(track)) {
      keyframe.points.push_back(*point);
    }
  }
  return keyframe;
}

std::optional<Eigen::Vector3d> VioFrontEnd::TruePoint(std::int64_t feature_id) const {
  for (const Track& track : tracks_) {
    if (track.id == feature_id && !track.is_outlier) {
      return track.p_W;
    }
  }
  return std::nullopt;
}

}  // namespace deja_view::sim
