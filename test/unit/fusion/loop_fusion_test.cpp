#include "deja_view/fusion/loop_fusion.hpp"

#include "deja_view/base/check.hpp"

#include <atomic>
#include <chrono>
#include <future>
#include <mutex>
#include <string>
#include <thread>
#include <utility>
#include <vector>

#include "wall_flight.hpp"
#include <gmock/gmock.h>
#include <gtest/gtest.h>

namespace deja_view {
namespace {

using test::WallFlight;
using ::testing::Contains;
using ::testing::HasSubstr;
using ::testing::IsEmpty;

constexpr int kKeyframes = 40;
const std::chrono::duration<double> kForever(600.0);

class LoopFusionTest : public ::testing::Test {
 protected:
  std::unique_ptr<LoopFusion> Make(const LoopFusionOptions& options = {}) {
    LoopFusionCallbacks callbacks;
    callbacks.on_keyframe =
        [this](const KeyframeInput& input, const KeyframeReport& report, const LoopCloser&) {
          go_on_.wait();
          stamps_.push_back(input.stamp_ns);
          for (const LoopReport& loop : report.loops) {
            loops_ += loop.accepted() ? 1 : 0;
          }
        };
    callbacks.on_problem = [this](const std::string& what) {
      const std::lock_guard<std::mutex> lock(problems_mutex_);
      problems_.push_back(what);
    };
    return std::make_unique<LoopFusion>(options, flight_.MakeLoopCloser(), std::move(callbacks));
  }

  void Add(LoopFusion* fusion, int i, std::size_t bytes = 1) {
    const KeyframeInput keyframe = flight_.Keyframe(i, kKeyframes);
    fusion->AddImage(
        keyframe.stamp_ns, [image = keyframe.image] { return image; }, bytes);
    fusion->AddPose(keyframe.stamp_ns, keyframe.T_W_B);
    fusion->AddPoints(keyframe.stamp_ns, keyframe.points);
  }

  void Block() { go_on_ = blocked_.get_future().share(); }
  void Unblock() { blocked_.set_value(); }

  WallFlight flight_;
  std::vector<std::int64_t> stamps_;
  int loops_ = 0;
  std::vector<std::string> problems_;
  std::mutex problems_mutex_;
  std::promise<void> blocked_;
  std::shared_future<void> go_on_ = [] {
    std::promise<void> promise;
    promise.set_value();
    return promise.get_future().share();
  }();
};

TEST_F(LoopFusionTest, GivesWhatTheLoopCloserGivesWithoutThreads) {
  LoopCloser closer = flight_.MakeLoopCloser();
  int loops = 0;
  for (int i = 0; i < kKeyframes; ++i) {
    for (const LoopReport& loop : closer.AddKeyframe(flight_.Keyframe(i, kKeyframes)).loops) {
      loops += loop.accepted() ? 1 : 0;
    }
  }
  ASSERT_GT(loops, 3);

  const auto fusion = Make();
  fusion->Start();
  for (int i = 0; i < kKeyframes; ++i) {
    Add(fusion.get(), i);
  }
  EXPECT_EQ(fusion->Stop(kForever), 0);
  EXPECT_THAT(problems_, IsEmpty());
  EXPECT_EQ(stamps_.size(), static_cast<std::size_t>(kKeyframes));
  EXPECT_TRUE(std::is_sorted(stamps_.begin(), stamps_.end()));
  EXPECT_EQ(loops_, loops);
  EXPECT_EQ(fusion->drift().t, closer.drift().t);
  EXPECT_EQ(fusion->drift().q.coeffs(), closer.drift().q.coeffs());
  const LoopFusionStatistics statistics = fusion->statistics();
  EXPECT_EQ(statistics.keyframes, kKeyframes);
  EXPECT_EQ(statistics.candidates.at("accepted"), loops);
  EXPECT_GT(statistics.mean_ms, 0.0);
  EXPECT_GE(statistics.max_ms, statistics.mean_ms);
}

TEST_F(LoopFusionTest, DropsTheOldestWhenTheQueueIsFullAndSaysSo) {
  LoopFusionOptions options;
  options.node.queue_size = 3;
  const auto fusion = Make(options);
  Block();
  fusion->Start();
  for (int i = 0; i < 10; ++i) {
    Add(fusion.get(), i);
  }
  Unblock();
  EXPECT_EQ(fusion->Stop(kForever), 0);
  const LoopFusionStatistics statistics = fusion->statistics();
  EXPECT_GE(statistics.queue_overflows, 6);  // one may be with the worker already
  EXPECT_EQ(statistics.queue_peak, 3);
  EXPECT_EQ(statistics.queue_overflows + statistics.keyframes, 10);
  EXPECT_EQ(stamps_.back(), flight_.Keyframe(9, kKeyframes).stamp_ns);
  EXPECT_THAT(problems_, Contains(HasSubstr("the queue of 3 keyframes")));
}

TEST_F(LoopFusionTest, BoundsWhatWaitsByItsBytes) {
  constexpr std::size_t kMegabyte = 1000000;
  LoopFusionOptions options;
  options.node.queue_memory_mb = 3.5;
  const auto fusion = Make(options);
  Block();
  fusion->Start();
  for (int i = 0; i < 10; ++i) {
    Add(fusion.get(), i, kMegabyte);
    fusion->AddVirtualView([]() -> VirtualView { ThrowInputError("no view"); }, kMegabyte);
  }
  EXPECT_LE(fusion->statistics().queue_length, 6);
  EXPECT_GE(fusion->statistics().queue_length, 5);
  fusion->AddVirtualView([]() -> VirtualView { ThrowInputError("huge"); }, 100 * kMegabyte);
  EXPECT_GE(fusion->statistics().queue_length, 3);  // one is kept, whatever its size
  Unblock();
  fusion->Stop(kForever);
  const LoopFusionStatistics statistics = fusion->statistics();
  EXPECT_GE(statistics.queue_overflows, 6);
  EXPECT_GE(statistics.view_overflows, 9);
  EXPECT_EQ(statistics.queue_overflows + statistics.keyframes, 10);
  EXPECT_THAT(problems_, Contains(HasSubstr("huge")));
}

TEST_F(LoopFusionTest, StopSaysWhatItLeaves) {
  const auto fusion = Make();
  Block();
  fusion->Start();
  for (int i = 0; i < 5; ++i) {
    Add(fusion.get(), i);
  }
  auto left = std::async(std::launch::async,
                         [&fusion] { return fusion->Stop(std::chrono::duration<double>(0.0)); });
  std::this_thread::sleep_for(std::chrono::milliseconds(50));
  Unblock();
  EXPECT_GE(left.get(), 4);
  EXPECT_EQ(fusion->statistics().queue_length, 0);
}

TEST_F(LoopFusionTest, KeyframesThatCannotBeUsedAreReportedAndSkipped) {
  const auto fusion = Make();
  fusion->Start();
  for (int i = 0; i < 6; ++i) {
    const KeyframeInput keyframe = flight_.Keyframe(i, kKeyframes);
    fusion->AddImage(
        keyframe.stamp_ns,
        [i, image = keyframe.image] {
          if (i == 2) {
            ThrowInputError("/camera: broken picture");
          }
          return i == 4 ? cv::Mat(image, cv::Rect(0, 0, 100, 100)).clone() : image;
        },
        1);
    fusion->AddPose(keyframe.stamp_ns, keyframe.T_W_B);
    fusion->AddPoints(keyframe.stamp_ns, keyframe.points);
  }
  fusion->Stop(kForever);
  EXPECT_EQ(stamps_.size(), 4U);
  EXPECT_EQ(fusion->statistics().refused, 2);
  EXPECT_THAT(problems_, Contains(HasSubstr("broken picture")));
  EXPECT_THAT(problems_, Contains(HasSubstr("100")));
}

TEST_F(LoopFusionTest, ABrokenInvariantEndsTheWork) {
  const auto fusion = Make();
  fusion->Start();
  for (int i = 0; i < 3; ++i) {
    const KeyframeInput keyframe = flight_.Keyframe(i, kKeyframes);
    fusion->AddImage(
        keyframe.stamp_ns,
        [i, image = keyframe.image] {
          DEJA_VIEW_CHECK_OP(i, !=, 1);
          return image;
        },
        1);
    fusion->AddPose(keyframe.stamp_ns, keyframe.T_W_B);
    fusion->AddPoints(keyframe.stamp_ns, keyframe.points);
  }
  EXPECT_EQ(fusion->Stop(kForever), 1);
  EXPECT_EQ(stamps_.size(), 1U);
  EXPECT_EQ(fusion->statistics().refused, 0);
  EXPECT_TRUE(fusion->errors().has_failed());
  EXPECT_THROW(fusion->errors().RethrowFailure(), CheckError);
}

TEST_F(LoopFusionTest, RelativePosesOfUnknownKeyframesAreIgnored) {
  const auto fusion = Make();
  fusion->Start();
  RelativePoseUpdate update;
  update.current = 7;
  fusion->AddRelativePose(update);
  fusion->Stop(kForever);
  EXPECT_EQ(fusion->statistics().relative_poses_ignored, 1);
  EXPECT_EQ(fusion->statistics().relative_poses, 0);
}

TEST_F(LoopFusionTest, TheLoopCloserCanBeUsedBetweenKeyframes) {
  const auto fusion = Make();
  fusion->Start();
  for (int i = 0; i < 20; ++i) {
    Add(fusion.get(), i);
    const int count = fusion->WithLoopCloser([](LoopCloser& c) { return c.keyframe_count(); });
    EXPECT_LE(count, i + 1);
  }
  fusion->Stop(kForever);
  EXPECT_EQ(fusion->WithLoopCloser([](LoopCloser& c) { return c.keyframe_count(); }), 20);
}

TEST_F(LoopFusionTest, ChecksItsOptions) {
  LoopFusionOptions options;
  options.node.queue_size = 0;
  options.assembler.max_pending = 0;
  EXPECT_THROW(Make(options), InputError);
  EXPECT_THAT(options.Validate(), Contains(HasSubstr("node.queue_size")));
  EXPECT_THAT(options.Validate(), Contains(HasSubstr("assembler.max_pending")));
  EXPECT_THAT(LoopFusionOptions().Validate(), IsEmpty());
}

TEST_F(LoopFusionTest, MakesKeyframesOfImagesAndPosesAlone) {
  LoopFusionCallbacks callbacks;
  std::vector<std::size_t> points;
  callbacks.on_keyframe = [&](const KeyframeInput& input,
                              const KeyframeReport&,
                              const LoopCloser&) { points.push_back(input.points.size()); };
  callbacks.on_problem = [](const std::string& what) { ADD_FAILURE() << what; };
  LoopFusion fusion({}, flight_.MakeLoopCloser(), callbacks, flight_.camera(), flight_.T_B_C());
  fusion.Start();
  constexpr int kImages = 200;
  for (int i = 0; i < kImages; ++i) {
    const KeyframeInput frame = flight_.Keyframe(i, kImages);
    fusion.AddOdometry(frame.stamp_ns, frame.T_W_B);
    fusion.AddImage(
        frame.stamp_ns, [image = frame.image] { return image; }, 1);
  }
  fusion.Stop(kForever);
  const LoopFusionStatistics statistics = fusion.statistics();
  EXPECT_EQ(statistics.front_end.images, kImages);
  EXPECT_GT(statistics.keyframes, kImages / 3);
  EXPECT_EQ(statistics.front_end.keyframes, statistics.keyframes);
  EXPECT_GT(*std::max_element(points.begin(), points.end()), 30U);
}

// For ThreadSanitizer: everything that the node's threads do, at once, with solves on one more.
TEST_F(LoopFusionTest, IsUsedByManyThreads) {
  LoopCloserOptions options;
  options.solve.every_loops = 2;
  std::atomic<int> keyframes{0};
  LoopFusionCallbacks callbacks;
  callbacks.on_keyframe = [&](const KeyframeInput&, const KeyframeReport&, const LoopCloser&) {
    ++keyframes;
  };
  callbacks.on_problem = [](const std::string&) {};
  LoopFusion fusion(
      {}, flight_.MakeLoopCloser(options, LoopFusion::RunBeside), std::move(callbacks));
  fusion.Start();
  std::atomic<bool> is_over{false};
  const auto meanwhile = [&](auto call) {
    return std::async(std::launch::async, [&is_over, call] {
      while (!is_over) {
        call();
        std::this_thread::sleep_for(std::chrono::milliseconds(1));
      }
    });
  };
  std::vector<std::future<void>> others;
  others.push_back(meanwhile([&] { fusion.statistics(); }));
  others.push_back(meanwhile([&] { fusion.drift(); }));
  others.push_back(meanwhile(
      [&] { fusion.WithLoopCloser([](LoopCloser& c) { return c.accepted_loops().size(); }); }));
  others.push_back(meanwhile([&] {
    fusion.AddVirtualView([]() -> VirtualView { ThrowInputError("no view"); }, 1);
    fusion.AddExtrinsic(WallFlight::kStart, flight_.T_B_C());
  }));
  for (int i = 0; i < kKeyframes; ++i) {
    Add(&fusion, i);
    fusion.AddRelativePose({WallFlight::kStart, 1000, Rigid3(), 0});  // of no keyframe
  }
  EXPECT_EQ(fusion.Stop(kForever), 0);
  is_over = true;
  others.clear();  // waits
  EXPECT_EQ(keyframes, kKeyframes);
  EXPECT_GT(fusion.statistics().candidates.at("accepted"), 3);
}

TEST_F(LoopFusionTest, WhatBreaksInTheFrontEndIsKeptForTheProgram) {
  LoopFusionCallbacks callbacks;
  callbacks.on_problem = [](const std::string&) {};
  LoopFusion fusion({}, flight_.MakeLoopCloser(), callbacks, flight_.camera(), flight_.T_B_C());
  fusion.Start();
  fusion.AddImage(
      WallFlight::kStart, []() -> cv::Mat { throw CheckError("broken"); }, 1);
  fusion.AddOdometry(WallFlight::kStart, Rigid3());
  fusion.Stop(kForever);
  EXPECT_THROW(fusion.errors().RethrowFailure(), CheckError);
}

}  // namespace
}  // namespace deja_view
