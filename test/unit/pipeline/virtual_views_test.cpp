#include "deja_view/base/check.hpp"
#include "deja_view/features/make_feature_extractor.hpp"
#include "deja_view/lab/sim/exact_views.hpp"
#include "deja_view/pipeline/loop_closer.hpp"
#include "deja_view/views/virtual_features.hpp"

#include <algorithm>
#include <cmath>
#include <filesystem>
#include <fstream>
#include <functional>
#include <iterator>

#include "small_flight.hpp"
#include <gtest/gtest.h>
#include <opencv2/core.hpp>

namespace deja_view {
namespace {

namespace fs = std::filesystem;
using test::FlightOptions;
using test::FlightVocabulary;
using test::MakeCloser;
using test::SmallFlight;

/// Exact views of the first keyframes of the first session, image and depth.
const std::vector<VirtualView>& Views() {
  static const std::vector<VirtualView> views = [] {
    const sim::RecordedFlight& flight = SmallFlight(1);
    const sim::SimOptions options = test::SmallFlightOptions(1);
    const auto world = std::make_shared<const sim::World>(1, options.world, 1);
    const sim::Renderer renderer(world, flight.camera, 1, 1);
    sim::ExactViewOptions wide = sim::MakeExactViewPreset("wide");
    wide.count = 3;
    wide.min_distance_m = 0.1;
    wide.max_distance_m = 0.25;
    wide.max_angle_deg = 4;
    std::vector<VirtualView> all;
    for (std::size_t k = 0; k < 4; ++k) {
      const Rigid3 T_W_C = flight.T_W_B[k] * flight.T_B_C;
      for (const Rigid3& T_C_V : sim::SampleExactViewPoses(*world, T_W_C, wide, k)) {
        VirtualView view = sim::RenderExactView(renderer, flight.camera, T_W_C, T_C_V, wide);
        view.stamp_ns = flight.keyframes[k].stamp_ns;
        view.index = static_cast<std::int32_t>(all.size() % 3);
        all.push_back(view);
      }
    }
    return all;
  }();
  return views;
}

/// View `i` of keyframe `k`.
const VirtualView& View(std::size_t k, std::size_t i) {
  return Views().at(3 * k + i);
}

LoopCloser WithKeyframes(std::size_t count, const LoopCloserOptions& options = FlightOptions()) {
  const sim::RecordedFlight& flight = SmallFlight(1);
  LoopCloser closer(options, flight.camera, flight.T_B_C, FlightVocabulary());
  for (std::size_t k = 0; k < count; ++k) {
    closer.AddKeyframe(flight.keyframes[k]);
  }
  return closer;
}

TEST(VirtualViews, AreKeptUnderTheirKeyframe) {
  ASSERT_EQ(Views().size(), 12U);
  LoopCloser closer = WithKeyframes(2);
  EXPECT_EQ(closer.AddVirtualView(View(0, 0)), ViewOutcome::kKept);
  EXPECT_EQ(closer.AddVirtualView(View(0, 1)), ViewOutcome::kKept);
  EXPECT_EQ(closer.keyframe(0).views, 2);
  EXPECT_EQ(closer.keyframe(1).views, 0);
  EXPECT_EQ(closer.place_count(), 2) << "a view is no place of its own";
  EXPECT_EQ(closer.view_counts().kept, 2);
  EXPECT_EQ(closer.view_counts().received, 2);
}

TEST(VirtualViews, MayComeBeforeTheirKeyframe) {
  LoopCloser closer = WithKeyframes(1);
  EXPECT_EQ(closer.AddVirtualView(View(1, 0)), ViewOutcome::kWaiting);
  EXPECT_EQ(closer.view_counts().waiting, 1);
  closer.AddKeyframe(SmallFlight(1).keyframes[1]);
  EXPECT_EQ(closer.keyframe(1).views, 1);
  EXPECT_EQ(closer.view_counts().waiting, 0);
  EXPECT_EQ(closer.view_counts().kept, 1);
}

TEST(VirtualViews, OrderOfArrivalDoesNotMatter) {
  const auto file_of = [](bool before, const std::string& name) {
    const sim::RecordedFlight& flight = SmallFlight(1);
    LoopCloser closer = MakeCloser(1);
    for (std::size_t k = 0; k < 3; ++k) {
      for (std::size_t i = 0; i < 3 && before; ++i) {
        closer.AddVirtualView(View(k, i));
      }
      closer.AddKeyframe(flight.keyframes[k]);
      for (std::size_t i = 0; i < 3 && !before; ++i) {
        closer.AddVirtualView(View(k, i));
      }
    }
    EXPECT_EQ(closer.view_counts().kept, 9);
    const fs::path directory = fs::path(testing::TempDir()) / name;
    closer.Save(directory);
    std::ifstream stream(directory / "map.dvm", std::ios::binary);
    std::string bytes{std::istreambuf_iterator<char>(stream), {}};
    fs::remove_all(directory);
    return bytes;
  };
  EXPECT_EQ(file_of(true, "deja_view_before"), file_of(false, "deja_view_after"));
}

TEST(VirtualViews, StampsMayBeRounded) {
  LoopCloser closer = WithKeyframes(1);
  VirtualView view = View(0, 0);
  view.stamp_ns += 120;
  EXPECT_EQ(closer.AddVirtualView(view), ViewOutcome::kKept);
  view.stamp_ns += 1000;
  EXPECT_EQ(closer.AddVirtualView(view), ViewOutcome::kWaiting);
}

TEST(VirtualViews, DuplicatesAreDropped) {
  LoopCloser closer = WithKeyframes(1);
  closer.AddVirtualView(View(0, 0));
  EXPECT_EQ(closer.AddVirtualView(View(0, 0)), ViewOutcome::kDuplicate);
  EXPECT_EQ(closer.keyframe(0).views, 1);
  EXPECT_EQ(closer.view_counts().duplicates, 1);
}

TEST(VirtualViews, TheStoreOfWaitingViewsIsBounded) {
  LoopCloserOptions options = FlightOptions();
  options.views.max_waiting = 2;
  LoopCloser closer = WithKeyframes(1, options);
  for (std::size_t i = 0; i < 3; ++i) {
    closer.AddVirtualView(View(1, i));
  }
  EXPECT_EQ(closer.view_counts().waiting, 2);
  EXPECT_EQ(closer.view_counts().no_keyframe, 1);
  closer.AddKeyframe(SmallFlight(1).keyframes[1]);
  EXPECT_EQ(closer.keyframe(1).views, 2);
}

TEST(VirtualViews, AKeyframeThatIsNoPlaceTakesNone) {
  LoopCloserOptions options = FlightOptions();
  options.map_spacing_m = 100.0;
  options.map_spacing_deg = 180.0;
  LoopCloser closer = WithKeyframes(2, options);
  EXPECT_EQ(closer.place_count(), 1);
  EXPECT_EQ(closer.AddVirtualView(View(1, 0)), ViewOutcome::kNoPlace);
  EXPECT_EQ(closer.AddVirtualView(View(2, 0)), ViewOutcome::kWaiting);
  closer.AddKeyframe(SmallFlight(1).keyframes[2]);
  EXPECT_EQ(closer.view_counts().no_place, 2);
}

TEST(VirtualViews, FeaturesAloneAreEnough) {
  VirtualView view = View(0, 0);
  const auto extractor = MakeFeatureExtractor(FeatureOptions{});
  view.features = ExtractVirtualFeatures(view, *extractor, {}, 0.0);
  EXPECT_GT(view.features.features.keypoints.size(), 100U);
  view.image = view.depth_mm = cv::Mat();
  LoopCloser closer = WithKeyframes(1);
  EXPECT_EQ(closer.AddVirtualView(view), ViewOutcome::kKept);
  view.features.descriptor = "orb";
  EXPECT_THROW(closer.AddVirtualView(view), InputError);
  view.features.descriptor = "brief";
  view.features.depth_m.pop_back();
  EXPECT_THROW(closer.AddVirtualView(view), InputError);
  EXPECT_EQ(closer.view_counts().refused, 2);
}

TEST(VirtualViews, AnImageWithoutDepthIsEnough) {
  VirtualView view = View(0, 0);
  view.depth_mm = cv::Mat();
  LoopCloser closer = WithKeyframes(1);
  EXPECT_EQ(closer.AddVirtualView(view), ViewOutcome::kKept);
}

TEST(VirtualViews, MalformedOnesAreRefusedAndCounted) {
  LoopCloser closer = WithKeyframes(1);
  const auto expect_refused = [&](const std::function<void(VirtualView*)>& spoil,
                                  const std::string& why) {
    VirtualView view = View(0, 0);
    spoil(&view);
    try {
      closer.AddVirtualView(view);
      ADD_FAILURE() << why;
    } catch (const InputError& e) {
      EXPECT_NE(std::string(e.what()).find(why), std::string::npos) << e.what();
      EXPECT_NE(std::string(e.what()).find(std::to_string(view.stamp_ns)), std::string::npos);
    }
  };
  expect_refused([](VirtualView* v) { v->camera = nullptr; }, "no camera");
  expect_refused([](VirtualView* v) { v->index = -1; }, "index");
  expect_refused([](VirtualView* v) { v->T_C_V.t.x() = NAN; }, "T_C_V");
  expect_refused([](VirtualView* v) { v->image = v->image(cv::Rect(0, 0, 40, 40)); }, "image");
  expect_refused([](VirtualView* v) { v->depth_mm = cv::Mat(3, 3, CV_16UC1); }, "depth");
  expect_refused([](VirtualView* v) { v->certainty = cv::Mat(3, 3, CV_8UC1); }, "certainty");
  expect_refused([](VirtualView* v) { v->image = cv::Mat(); }, "no image");
  EXPECT_EQ(closer.view_counts().refused, 7);
  EXPECT_EQ(closer.keyframe(0).views, 0);
}

TEST(VirtualViews, UncertainOnesAreDropped) {
  VirtualView view = View(0, 0);
  view.certainty = cv::Mat(view.image.size(), CV_8UC1, cv::Scalar(20));
  LoopCloser closer = WithKeyframes(1);
  EXPECT_EQ(closer.AddVirtualView(view), ViewOutcome::kUncertain);
  view.certainty = cv::Mat(view.image.size(), CV_8UC1, cv::Scalar(250));
  EXPECT_EQ(closer.AddVirtualView(view), ViewOutcome::kKept);
}

TEST(VirtualViews, OnesThatShowSomethingElseAreDropped) {
  VirtualView view = View(0, 0);
  cv::Mat upside_down;
  cv::flip(view.image, upside_down, -1);
  view.image = upside_down;
  LoopCloser closer = WithKeyframes(1);
  EXPECT_EQ(closer.AddVirtualView(view), ViewOutcome::kDisagrees);
  EXPECT_EQ(closer.view_counts().disagree, 1);
}

TEST(VirtualViews, TheMostSimilarOnesAreKept) {
  // The source image itself is the most similar view there is.
  VirtualView same = View(0, 0);
  same.T_C_V = Rigid3::Identity();
  same.image = SmallFlight(1).keyframes[0].image;
  same.depth_mm = cv::Mat();
  same.index = 7;
  LoopCloserOptions options = FlightOptions();
  options.views.keep = 1;
  for (const bool is_first : {true, false}) {
    LoopCloser closer = WithKeyframes(1, options);
    const ViewOutcome first = closer.AddVirtualView(is_first ? same : View(0, 1));
    const ViewOutcome second = closer.AddVirtualView(is_first ? View(0, 1) : same);
    EXPECT_EQ(first, ViewOutcome::kKept);
    EXPECT_EQ(second, is_first ? ViewOutcome::kSurpassed : ViewOutcome::kKept);
    EXPECT_EQ(closer.keyframe(0).views, 1);
    EXPECT_EQ(closer.view_counts().kept, 1);
    EXPECT_EQ(closer.view_counts().surpassed, 1);
    EXPECT_EQ(closer.AddVirtualView(same), ViewOutcome::kDuplicate) << "it is the one kept";
  }
  options.views.keep = 0;
  LoopCloser closer = WithKeyframes(1, options);
  EXPECT_EQ(closer.AddVirtualView(same), ViewOutcome::kSurpassed);
}

TEST(VirtualViews, TakeLessThan20kB) {
  LoopCloserOptions options = FlightOptions();
  LoopCloser closer = WithKeyframes(4, options);
  for (const VirtualView& view : Views()) {
    closer.AddVirtualView(view);
  }
  const double each = static_cast<double>(closer.view_memory_bytes()) /
                      static_cast<double>(closer.view_counts().kept);
  EXPECT_GT(each, 4000);
  EXPECT_LT(each, 20000);
  EXPECT_LT(closer.view_memory_bytes(), closer.memory_bytes());
}

TEST(VirtualViews, AreSavedWithTheMap) {
  const fs::path directory = fs::path(testing::TempDir()) / "deja_view_views_map";
  LoopCloser closer = WithKeyframes(3);
  for (const VirtualView& view : Views()) {
    closer.AddVirtualView(view);
  }
  closer.Save(directory);
  LoopCloser loaded = MakeCloser(2);
  loaded.Load(directory);
  EXPECT_EQ(loaded.view_counts().kept, 9);
  for (int k = 0; k < 3; ++k) {
    EXPECT_EQ(loaded.keyframe(k).views, 3);
    EXPECT_TRUE(loaded.keyframe(k).is_place);
  }
  EXPECT_EQ(loaded.AddVirtualView(View(0, 0)), ViewOutcome::kDuplicate);
  const fs::path again = fs::path(testing::TempDir()) / "deja_view_views_map_again";
  loaded.Save(again);
  EXPECT_EQ(fs::file_size(directory / "map.dvm"), fs::file_size(again / "map.dvm"));
  LoopCloserOptions options = FlightOptions();
  options.views.keep = 0;
  LoopCloser without = WithKeyframes(0, options);
  without.Load(directory);
  EXPECT_EQ(without.view_counts().kept, 0);
  fs::remove_all(directory);
  fs::remove_all(again);
}

/// Every loop stands for itself, and only virtual views can show one.
LoopCloserOptions OnlyViewsOptions() {
  LoopCloserOptions options = FlightOptions();
  options.consistency.min_support = 0;
  options.consistency.min_support_join = 0;
  options.consistency.min_span_over_depth = 0;
  options.candidates.min_age_s = 0.1;
  options.verification.max_log10_false_alarms = -400;
  return options;
}

/// Where a second session looks from a virtual camera's place, that camera is a candidate's reason
/// to be accepted, and the loop says so.
TEST(VirtualViews, ALoopThatNeedsThemIsMarked) {
  const sim::RecordedFlight& flight = SmallFlight(1);
  LoopCloser closer(OnlyViewsOptions(), flight.camera, flight.T_B_C, FlightVocabulary());
  closer.AddKeyframe(flight.keyframes[0]);
  EXPECT_TRUE(closer.AddKeyframe(flight.keyframes[1]).loops.front().is_virtual == false);
  for (std::size_t i = 0; i < 3; ++i) {
    ASSERT_EQ(closer.AddVirtualView(View(0, i)), ViewOutcome::kKept);
  }
  const KeyframeReport report = closer.AddKeyframe(flight.keyframes[2]);
  const auto loop = std::find_if(report.loops.begin(), report.loops.end(), [](const auto& l) {
    return l.old == 0 && l.accepted();
  });
  ASSERT_NE(loop, report.loops.end());
  EXPECT_TRUE(loop->is_virtual);
  EXPECT_FALSE(report.relocalisation) << "of no use to the VIO";
  const Rigid3 truth = flight.T_W_B[0].Inverse() * flight.T_W_B[2];
  EXPECT_LT((loop->T_Bold_Bcurrent.t - truth.t).norm(), 0.1);
}

TEST(VirtualViews, NoMoreAreTriedThanAllowed) {
  const sim::RecordedFlight& flight = SmallFlight(1);
  const auto loops_with = [&](int max_tried) {
    LoopCloserOptions options = OnlyViewsOptions();
    options.views.max_tried = max_tried;
    LoopCloser closer(options, flight.camera, flight.T_B_C, FlightVocabulary());
    for (std::size_t k = 0; k < 2; ++k) {
      closer.AddKeyframe(flight.keyframes[k]);
      closer.AddVirtualView(View(k, 0));
      closer.AddVirtualView(View(k, 1));
    }
    const KeyframeReport report = closer.AddKeyframe(flight.keyframes[2]);
    EXPECT_EQ(report.loops.size(), 2U) << "one per candidate, tried or not";
    EXPECT_EQ(report.reason == RejectReason::kNone, max_tried > 0);
    return std::count_if(report.loops.begin(), report.loops.end(), [](const LoopReport& loop) {
      return loop.is_virtual;
    });
  };
  EXPECT_EQ(loops_with(0), 0);
  EXPECT_EQ(loops_with(1), 1);
  EXPECT_EQ(loops_with(2), 2);
}

TEST(VirtualViews, NoneAreTriedOutOfReach) {
  const sim::RecordedFlight& flight = SmallFlight(1);
  for (const double jump_m : {0.0, 20.0}) {
    LoopCloserOptions options = OnlyViewsOptions();
    options.max_speed_mps = 1e6;  // no new sequence
    LoopCloser closer(options, flight.camera, flight.T_B_C, FlightVocabulary());
    closer.AddKeyframe(flight.keyframes[0]);
    closer.AddVirtualView(View(0, 0));
    closer.AddVirtualView(View(0, 1));
    closer.AddKeyframe(flight.keyframes[1]);
    ASSERT_EQ(closer.AddKeyframe(flight.keyframes[2]).reason, RejectReason::kNone) << "localised";
    KeyframeInput jumped = flight.keyframes[3];
    jumped.T_W_B.t.x() += jump_m;
    for (TrackedPoint& point : jumped.points) {
      point.p_W.x() += jump_m;
    }
    const KeyframeReport report = closer.AddKeyframe(jumped);
    const bool was_tried = std::any_of(report.loops.begin(),
                                       report.loops.end(),
                                       [](const LoopReport& loop) { return loop.is_virtual; });
    EXPECT_EQ(was_tried, jump_m == 0) << jump_m << " m";
  }
}

}  // namespace
}  // namespace deja_view
