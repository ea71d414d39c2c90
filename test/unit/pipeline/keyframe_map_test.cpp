#include "keyframe_map.hpp"

#include "deja_view/base/check.hpp"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

namespace deja_view {
namespace {

StoredKeyframe Keyframe(std::int64_t stamp_ns) {
  StoredKeyframe keyframe;
  keyframe.stamp_ns = stamp_ns;
  keyframe.features.T_B_C.t.x() = 0.1;
  return keyframe;
}

Rigid3 At(double x) {
  return {FromYaw(0.5), {x, 0, 0}};
}

TEST(KeyframeMap, KeyframesAreTheGraphsNodes) {
  KeyframeMap map{PoseGraphOptions{}};
  EXPECT_EQ(map.sequence_count(), 0);
  EXPECT_EQ(map.newest(), -1);
  EXPECT_EQ(map.Add(Keyframe(1000), 0, At(1)), 0);
  EXPECT_EQ(map.Add(Keyframe(2000), 0, At(3)), 1);
  EXPECT_EQ(map.Add(Keyframe(9000), 1, At(0)), 2);
  EXPECT_EQ(map.size(), 3);
  EXPECT_EQ(map.sequence_count(), 2);
  EXPECT_EQ(map[1].stamp_ns, 2000);
  EXPECT_EQ(map.node(1).T_W_B.t.x(), 3);
  EXPECT_TRUE(map.AreJoined(0, 1));
  EXPECT_FALSE(map.AreJoined(0, 2));
  EXPECT_LT((map.T_M_C(1).t - (At(3) * Eigen::Vector3d(0.1, 0, 0))).norm(), 1e-12);
  EXPECT_LT((map.T_a_b(0, 1).t - At(1).Inverse() * At(3).t).norm(), 1e-12);
}

TEST(KeyframeMap, OnlyPlacesKeepFeatures) {
  KeyframeMap map{PoseGraphOptions{}};
  map.Add(Keyframe(1000), 0, At(1));
  map.Add(Keyframe(2000), 0, At(2));
  KeyframeFeatures features;
  features.keypoints.emplace_back(3, 4);
  map.MakePlace(features);
  EXPECT_THAT(map.places(), testing::ElementsAre(1));
  EXPECT_FALSE(map[0].is_place);
  EXPECT_TRUE(map[1].is_place);
  EXPECT_EQ(map.features(1).keypoints.size(), 1U);
  EXPECT_THROW(map.MakePlace(features), CheckError) << "it is one already";
}

TEST(KeyframeMap, FindsAKeyframeByItsRoundedStamp) {
  KeyframeMap map{PoseGraphOptions{}};
  map.Add(Keyframe(1'000'000), 0, At(1));
  map.Add(Keyframe(1'000'700), 0, At(2));
  map.Add(Keyframe(1'000'000), 1, At(3));
  EXPECT_EQ(map.At(1'000'000), 2) << "the newest of one stamp";
  EXPECT_EQ(map.At(1'000'340), 2);
  EXPECT_EQ(map.At(1'000'360), 1);
  EXPECT_EQ(map.At(999'500), 2);
  EXPECT_EQ(map.At(999'499), std::nullopt);
  EXPECT_EQ(map.At(1'001'201), std::nullopt);
}

TEST(KeyframeMap, IsMadeOfPartsThatFit) {
  PoseGraph graph{PoseGraphOptions{}};
  graph.AddNode(0, At(1));
  graph.AddNode(0, At(2));
  std::vector<StoredKeyframe> keyframes = {Keyframe(1000), Keyframe(2000)};
  keyframes[1].is_place = true;
  const KeyframeMap map(keyframes, graph);
  EXPECT_THAT(map.places(), testing::ElementsAre(1));
  EXPECT_EQ(map.At(2000), 1);
  keyframes.pop_back();
  EXPECT_THROW(KeyframeMap(keyframes, graph), CheckError);
}

}  // namespace
}  // namespace deja_view
