#pragma once

#include "deja_view/camera/pinhole_camera.hpp"
#include "deja_view/pipeline/loop_closer.hpp"

#include <cmath>
#include <cstdint>
#include <memory>
#include <random>
#include <utility>
#include <vector>

#include "random_vocabulary.hpp"
#include "synthetic_image.hpp"

namespace deja_view::test {

/// A flight along a painted wall, there and back, that drifts: images are cut from one large
/// picture.
class WallFlight {
 public:
  static constexpr int kWidth = 376;
  static constexpr int kHeight = 240;
  static constexpr std::int64_t kStart = 1403636627638560000;

  WallFlight() : wall_(SyntheticImage(3 * kWidth, kHeight, 5)) {
    PinholeParameters p;
    p.width = kWidth;
    p.height = kHeight;
    p.fx = kFocal;
    p.fy = kFocal;
    p.cx = kWidth / 2.0;
    p.cy = kHeight / 2.0;
    camera_ = std::make_shared<PinholeCamera>(p);
    Eigen::Matrix3d R_B_C;  // looks along the body's x axis, z up
    R_B_C << 0, 0, 1, -1, 0, 0, 0, -1, 0;
    T_B_C_.q = Eigen::Quaterniond(R_B_C);
  }

  LoopCloser MakeLoopCloser(const LoopCloserOptions& options = {},
                            SolveExecutor executor = {}) const {
    const auto vocabulary = Vocabulary::FromTree(RandomTree(10, 3, 1));
    return {options, camera_, T_B_C_, vocabulary, std::move(executor)};
  }

  const std::shared_ptr<const Camera>& camera() const { return camera_; }
  const Rigid3& T_B_C() const { return T_B_C_; }

  /// Keyframe `i` of `count`, half a second apart.
  KeyframeInput Keyframe(int i, int count) const {
    const int half = count / 2;
    const int shift = 2 * kWidth * (i <= half ? i : count - i) / half;
    KeyframeInput input;
    input.stamp_ns = kStart + std::int64_t{i} * 500000000;
    input.image = wall_(cv::Rect(shift, 0, kWidth, kHeight)).clone();
    Rigid3 T_M_B;
    T_M_B.t.y() = -shift * kDistance / kFocal;
    input.T_W_B = T_M_B;
    input.T_W_B.t.x() += kDrift * i;
    std::mt19937 random(static_cast<std::uint32_t>(i));
    for (int n = 0; n < 120; ++n) {
      TrackedPoint point;
      point.pixel = Eigen::Vector2f(static_cast<float>(30 + random() % (kWidth - 60)),
                                    static_cast<float>(30 + random() % (kHeight - 60)));
      const Eigen::Vector3d ray((point.pixel.x() - kWidth / 2.0) / kFocal,
                                (point.pixel.y() - kHeight / 2.0) / kFocal,
                                1.0);
      point.p_W = input.T_W_B * (T_B_C_ * (kDistance * ray));
      point.feature_id = i * 1000 + n;
      input.points.push_back(point);
    }
    return input;
  }

 private:
  static constexpr double kFocal = 230.0;   // [px]
  static constexpr double kDistance = 3.0;  // [m] of the wall
  static constexpr double kDrift = 0.004;   // [m] per keyframe

  cv::Mat wall_;
  std::shared_ptr<const Camera> camera_;
  Rigid3 T_B_C_;
};

}  // namespace deja_view::test
