#pragma once

#include "deja_view/host/keyframe_assembler.hpp"

#include <cmath>
#include <cstdint>
#include <utility>
#include <vector>

#include <gtest/gtest.h>
#include <opencv2/core/mat.hpp>

namespace deja_view {

inline constexpr std::int64_t kMillisecond = 1000000;
inline constexpr std::int64_t kStart = 1403636627638560000;

inline std::int64_t Stamp(int milliseconds) {
  return kStart + milliseconds * kMillisecond;
}

// What came out: offset of the stamp from kStart [ms] and number of points.
using Output = std::vector<std::pair<int, int>>;

class KeyframeAssemblerTest : public ::testing::Test {
 protected:
  void Reset(const KeyframeAssemblerOptions& options) {
    output_.clear();
    drops_.clear();
    extrinsics_.clear();
    sequence_starts_.clear();
    decoded_ = 0;
    assembler_ = KeyframeAssembler(
        options,
        [this](const AssembledKeyframe& keyframe) {
          const KeyframeInput input = keyframe.ToInput();
          EXPECT_EQ(input.image.rows, 2);
          output_.emplace_back(Offset(keyframe.stamp_ns), static_cast<int>(keyframe.points.size()));
          if (keyframe.starts_sequence) {
            sequence_starts_.push_back(Offset(keyframe.stamp_ns));
          }
          extrinsics_.push_back(keyframe.T_B_C ? keyframe.T_B_C->t.x() : -1.0);
        },
        [this](DropReason reason, std::int64_t stamp_ns) {
          drops_.emplace_back(reason, Offset(stamp_ns));
        });
  }

  static int Offset(std::int64_t stamp_ns) {
    return static_cast<int>(std::lround(1e-6 * static_cast<double>(stamp_ns - kStart)));
  }

  void Image(int ms) {
    assembler_.AddImage(
        Stamp(ms),
        [this] {
          ++decoded_;
          return cv::Mat(2, 3, CV_8UC1, cv::Scalar(7));
        },
        1000000);
  }
  void Pose(int ms) { assembler_.AddPose(Stamp(ms), Rigid3::Identity()); }
  void Points(int ms, int count = 3) {
    assembler_.AddPoints(Stamp(ms), std::vector<TrackedPoint>(static_cast<std::size_t>(count)));
  }
  void Extrinsic(int ms, double x) {
    Rigid3 T_B_C;
    T_B_C.t.x() = x;
    assembler_.AddExtrinsic(Stamp(ms), T_B_C);
  }
  void Keyframe(int ms) {
    Image(ms);
    Pose(ms);
    Points(ms);
  }

  Output output_;
  std::vector<std::pair<DropReason, int>> drops_;
  std::vector<double> extrinsics_;
  std::vector<int> sequence_starts_;
  int decoded_ = 0;
  KeyframeAssembler assembler_{{}, [](const AssembledKeyframe&) {}, nullptr};
};

}  // namespace deja_view
