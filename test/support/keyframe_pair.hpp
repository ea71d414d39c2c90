#pragma once

#include "deja_view/verification/loop_verifier.hpp"

#include <memory>
#include <random>
#include <vector>

#include "random_vocabulary.hpp"
#include "test_cameras.hpp"

namespace deja_view::test {

struct KeyframePairOptions {
  int tracked = 120;             ///< points with a position, per keyframe
  int corners = 300;             ///< points of the room
  int clutter = 100;             ///< keypoints that show no point of the room, per keyframe
  int recognised = 1000;         ///< points of the room whose descriptor is alike in both images
  double room = 1.0;             ///< half width of the room over its usual 3.5 m x 2 m
  double pixel_sigma = 0.3;      ///< [px]
  double depth_sigma = 0.02;     ///< of the depth
  int descriptor_noise = 12;     ///< [bits]
  bool scatters_pixels = false;  ///< keypoints stand anywhere: descriptors match, geometry does not
  std::uint64_t seed = 1;
};

/// A keyframe of a room of random points. Entry i of `keypoint_ids` is the room's point that
/// keypoint i shows, -1 for clutter; the points' ids are the features' point_ids.
struct SyntheticKeyframe {
  Rigid3 T_W_B;
  KeyframeFeatures features;
  std::vector<std::int64_t> keypoint_ids;
};

struct KeyframePair {
  std::shared_ptr<const Camera> camera;
  SyntheticKeyframe old;
  SyntheticKeyframe current;

  Rigid3 T_old_current() const { return old.T_W_B.Inverse() * current.T_W_B; }
};

inline std::shared_ptr<const Camera> WideCamera() {
  return SharedPinholeOf(752, 480, 458, 375, 239);
}

/// The camera looks along the body's x axis.
inline Rigid3 ForwardExtrinsic() {
  Eigen::Matrix3d R_B_C;
  R_B_C << 0, 0, 1, -1, 0, 0, 0, -1, 0;
  return {Eigen::Quaterniond(R_B_C), {0.05, 0.02, -0.01}};
}

/// Two views of the room, 0.6 m and 14 degrees of yaw apart, both tilted a little.
inline KeyframePair MakeKeyframePair(const KeyframePairOptions& options) {
  std::mt19937_64 rng(options.seed);
  std::uniform_real_distribution<double> uniform(-1, 1);
  std::normal_distribution<double> normal;
  KeyframePair pair;
  pair.camera = WideCamera();
  pair.old.T_W_B = {FromYaw(0.1) * ExpSo3({0.05, -0.03, 0}), {0, 0, 1}};
  pair.current.T_W_B = {FromYaw(-0.15) * ExpSo3({-0.04, 0.06, 0}), {0.3, 0.5, 1.15}};
  std::vector<Eigen::Vector3d> room;
  std::vector<Descriptor> looks;
  for (int i = 0; i < options.corners; ++i) {
    room.emplace_back(5.5 + 2.0 * options.room * uniform(rng),
                      3.5 * options.room * uniform(rng),
                      1.0 + 2.0 * options.room * uniform(rng));
    looks.push_back(RandomDescriptor(&rng));
  }
  const auto pixel_noise = [&] {
    const double x = normal(rng);
    return Eigen::Vector2d(options.pixel_sigma * x, options.pixel_sigma * normal(rng));
  };
  const auto anywhere = [&] {
    const double x = 375 + 370 * uniform(rng);
    return Eigen::Vector2d(x, 239 + 230 * uniform(rng));
  };
  for (SyntheticKeyframe* keyframe : {&pair.old, &pair.current}) {
    KeyframeFeatures& f = keyframe->features;
    f.T_B_C = ForwardExtrinsic();
    const Rigid3 T_C_W = (keyframe->T_W_B * f.T_B_C).Inverse();
    for (std::size_t i = 0; i < room.size(); ++i) {
      const Eigen::Vector3d p_C = T_C_W * room[i];
      const auto seen = pair.camera->Project(p_C);
      if (!seen || !pair.camera->IsInImage(*seen, 3.0)) {
        continue;
      }
      const bool is_recognised = static_cast<int>(i) < options.recognised;
      const Descriptor look = is_recognised ? looks[i] : RandomDescriptor(&rng);
      const Eigen::Vector2d pixel = options.scatters_pixels ? anywhere() : *seen + pixel_noise();
      f.keypoints.push_back(pixel.cast<float>());
      f.descriptors.push_back(Disturb(look, options.descriptor_noise, &rng));
      keyframe->keypoint_ids.push_back(static_cast<std::int64_t>(i));
      if (static_cast<int>(f.points_B.size()) < options.tracked) {
        const double scale = 1.0 + options.depth_sigma * normal(rng);
        f.points_B.push_back((f.T_B_C * (scale * p_C)).cast<float>());
        f.point_pixels.push_back(seen->cast<float>());
        f.point_depth_sigmas.push_back(
            static_cast<float>(std::max(0.01, options.depth_sigma) * p_C.norm()));
        f.point_ids.push_back(static_cast<std::int64_t>(i));
        f.point_descriptors.push_back(Disturb(look, options.descriptor_noise, &rng));
      }
    }
    for (int i = 0; i < options.clutter; ++i) {
      f.keypoints.push_back(anywhere().cast<float>());
      f.descriptors.push_back(RandomDescriptor(&rng));
      keyframe->keypoint_ids.push_back(-1);
    }
  }
  return pair;
}

}  // namespace deja_view::test
