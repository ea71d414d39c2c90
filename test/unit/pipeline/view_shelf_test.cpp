#include "view_shelf.hpp"

#include "deja_view/base/check.hpp"
#include "deja_view/features/make_feature_extractor.hpp"

#include <string>
#include <utility>

#include "keyframe_pair.hpp"
#include "random_vocabulary.hpp"
#include "synthetic_image.hpp"
#include <gmock/gmock.h>
#include <gtest/gtest.h>

namespace deja_view {
namespace {

using testing::ElementsAre;
using testing::IsEmpty;

/// Keyframe i of a room at i seconds, all alike; the last one is no place.
class ViewShelfTest : public testing::Test {
 protected:
  static constexpr std::int64_t kSecond = 1'000'000'000;

  ViewShelfTest()
      : pair_(test::MakeKeyframePair({})),
        vocabulary_(Vocabulary::FromTree(test::RandomTree(5, 3, 7))),
        verifier_({}, pair_.camera),
        places_({}, {}, {}, vocabulary_),
        keyframes_(PoseGraphOptions{}) {
    for (int i = 0; i < 3; ++i) {
      AddKeyframe(i, i < 2);
    }
  }

  void AddKeyframe(int i, bool is_place) {
    StoredKeyframe keyframe;
    keyframe.stamp_ns = i * kSecond;
    keyframe.features.T_B_C = test::ForwardExtrinsic();
    keyframes_.Add(keyframe, 0, pair_.old.T_W_B);
    if (is_place) {
      keyframes_.MakePlace(pair_.old.features);
      places_.Add(i, 0, keyframe.stamp_ns, places_.Words(pair_.old.features.descriptors));
    }
  }

  ViewShelf Make() { return {options_, FeatureOptions{}, &verifier_, &places_}; }

  /// A view from the source's own camera that has its first `shared` features and as many of its
  /// own that the source has not; `shared` tells how similar it is.
  VirtualView View(int keyframe, int index, std::size_t shared = 200) {
    const KeyframeFeatures& source = pair_.old.features;
    VirtualView view;
    view.stamp_ns = keyframe * kSecond;
    view.index = index;
    view.camera = pair_.camera;
    view.features.descriptor = "brief";
    std::mt19937_64 rng(static_cast<std::uint64_t>(index) + 1);
    for (std::size_t i = 0; i < 250; ++i) {
      const Eigen::Vector2f& pixel = source.keypoints.at(i);
      view.features.features.keypoints.push_back({pixel.x(), pixel.y(), 1.0F});
      view.features.features.descriptors.push_back(i < shared ? source.descriptors[i]
                                                              : test::RandomDescriptor(&rng));
      view.features.depth_m.push_back(0);
      view.features.depth_sigma_m.push_back(0);
    }
    return view;
  }

  /// The numbers of the cameras in the rigs of keyframe 1.
  static std::vector<std::vector<int>> Numbers(const ViewShelf& shelf,
                                               const std::optional<NearCamera>& near,
                                               const BowVector& bow) {
    std::vector<std::vector<int>> result;
    for (const std::vector<RigCamera>& rig : shelf.RigsOf(1, test::ForwardExtrinsic(), near, bow)) {
      result.emplace_back();
      for (const RigCamera& camera : rig) {
        result.back().push_back(camera.number);
      }
    }
    return result;
  }

  std::vector<int> Indices(const ViewShelf& shelf, int keyframe) const {
    std::vector<int> indices;
    for (const StoredView& view : shelf.Of(keyframe)) {
      indices.push_back(view.index);
    }
    return indices;
  }

  test::KeyframePair pair_;
  std::shared_ptr<const Vocabulary> vocabulary_;
  LoopVerifier verifier_;
  PlaceFinder places_;
  KeyframeMap keyframes_;
  VirtualViewOptions options_;
};

TEST_F(ViewShelfTest, KeepsAViewWithItsKeyframe) {
  ViewShelf shelf = Make();
  EXPECT_EQ(shelf.Add(View(1, 5), keyframes_), ViewOutcome::kKept);
  EXPECT_EQ(shelf.Add(View(1, 3), keyframes_), ViewOutcome::kKept);
  EXPECT_EQ(shelf.Add(View(1, 5), keyframes_), ViewOutcome::kDuplicate);
  EXPECT_EQ(shelf.Add(View(2, 5), keyframes_), ViewOutcome::kNoPlace);
  EXPECT_THAT(Indices(shelf, 1), ElementsAre(5, 3));
  EXPECT_THAT(Indices(shelf, 0), IsEmpty());
  EXPECT_EQ(shelf.counts().received, 4);
  EXPECT_EQ(shelf.counts().kept, 2);
  EXPECT_EQ(shelf.counts().duplicates, 1);
  EXPECT_EQ(shelf.counts().no_place, 1);
  EXPECT_GT(shelf.memory_bytes(), 2 * 250 * sizeof(Descriptor));
}

TEST_F(ViewShelfTest, RigsHaveTheViewsNearestToTheDroneFirst) {
  options_.in_rig = 2;
  options_.rigs = 2;
  ViewShelf shelf = Make();
  for (const int index : {5, 6, 7, 8, 9}) {
    VirtualView view = View(1, index);
    view.T_C_V.t.x() += 0.001 * index;
    ASSERT_EQ(shelf.Add(view, keyframes_), ViewOutcome::kKept);
  }
  const auto numbers = [&](const NearCamera& near) { return Numbers(shelf, near, {}); };
  const auto at = [&](std::size_t i, double turned) {
    Rigid3 T_C_near = shelf.Of(1)[i].T_C_V;
    T_C_near.q = T_C_near.q * ExpSo3({0, turned, 0});
    return NearCamera{T_C_near, 3};
  };
  EXPECT_THAT(numbers(at(4, 0)), ElementsAre(ElementsAre(9, 8), ElementsAre(7, 6)));
  EXPECT_THAT(numbers(at(0, 0.3)), ElementsAre(ElementsAre(5, 6), ElementsAre(7, 8)));
  EXPECT_TRUE(shelf.RigsOf(0, test::ForwardExtrinsic(), std::nullopt, {}).empty());
}

TEST_F(ViewShelfTest, RigsHaveTheViewsThatLookMostAlikeFirstWhereNobodyKnowsTheDrones) {
  options_.min_agreement = 0;
  options_.rigs = 3;
  ViewShelf shelf = Make();
  for (const int shared : {60, 200, 120, 30}) {
    const auto index = shared;
    ASSERT_EQ(shelf.Add(View(1, index, static_cast<std::size_t>(shared)), keyframes_),
              ViewOutcome::kKept);
  }
  const BowVector source = vocabulary_->Bag(pair_.old.features.descriptors);
  EXPECT_THAT(Numbers(shelf, std::nullopt, source),
              ElementsAre(ElementsAre(200), ElementsAre(120), ElementsAre(60)));
  const BowVector last = vocabulary_->Bag(View(1, 30, 30).features.features.descriptors);
  EXPECT_THAT(Numbers(shelf, std::nullopt, last).at(0), ElementsAre(30));
}

TEST_F(ViewShelfTest, IndexesWhatItKeepsAndNoMore) {
  options_.keep = 1;
  ViewShelf shelf = Make();
  shelf.Add(View(0, 1, 150), keyframes_);
  EXPECT_GT(places_.view_memory_bytes(), 0U);
  const std::size_t bytes = shelf.memory_bytes();
  EXPECT_EQ(shelf.Add(View(0, 2, 100), keyframes_), ViewOutcome::kSurpassed);
  EXPECT_THAT(Indices(shelf, 0), ElementsAre(1));
  EXPECT_EQ(shelf.Add(View(0, 3, 240), keyframes_), ViewOutcome::kKept);
  EXPECT_THAT(Indices(shelf, 0), ElementsAre(3)) << "more like its source";
  EXPECT_EQ(shelf.counts().kept, 1);
  EXPECT_EQ(shelf.counts().surpassed, 2);
  EXPECT_EQ(shelf.memory_bytes(), bytes);
  // The dropped one's tag is free again: it is out of the index.
  EXPECT_NO_THROW(places_.AddView(0, 1, places_.Bag(View(0, 1).features.features.descriptors)));
}

TEST_F(ViewShelfTest, ViewsWaitForTheirKeyframe) {
  options_.max_waiting = 2;
  ViewShelf shelf = Make();
  for (const int index : {0, 1, 2}) {
    EXPECT_EQ(shelf.Add(View(3, index), keyframes_), ViewOutcome::kWaiting);
  }
  EXPECT_EQ(shelf.counts().waiting, 2);
  EXPECT_EQ(shelf.counts().no_keyframe, 1) << "the oldest";
  AddKeyframe(3, true);
  shelf.AttachWaiting(3, keyframes_);
  EXPECT_THAT(Indices(shelf, 3), ElementsAre(1, 2));
  EXPECT_EQ(shelf.counts().waiting, 0);
  EXPECT_EQ(shelf.counts().kept, 2);
}

TEST_F(ViewShelfTest, ViewsWaitWithinTheirMemory) {
  options_.max_waiting_mb = 1;
  ViewShelf shelf = Make();
  VirtualView view = View(3, 0);
  view.image = cv::Mat(view.camera->height(), view.camera->width(), CV_8UC1, cv::Scalar(7));
  for (int i = 0; i < 5; ++i) {  // of 0.34 MiB each
    view.index = i;
    EXPECT_EQ(shelf.Add(view, keyframes_), ViewOutcome::kWaiting);
  }
  EXPECT_EQ(shelf.counts().waiting, 2);
  EXPECT_EQ(shelf.counts().no_keyframe, 3);
  AddKeyframe(3, true);
  shelf.AttachWaiting(3, keyframes_);
  EXPECT_THAT(Indices(shelf, 3), ElementsAre(3, 4));
  for (const int index : {5, 6}) {
    view.stamp_ns = 4 * kSecond;
    view.index = index;
    EXPECT_EQ(shelf.Add(view, keyframes_), ViewOutcome::kWaiting);
  }
  EXPECT_EQ(shelf.counts().waiting, 2) << "the others' memory is free again";
}

TEST_F(ViewShelfTest, TakesOnlyFeaturesThatAreTurnedAsTheWorldStands) {
  ViewShelf shelf = Make();
  VirtualView view = View(0, 0);
  view.T_C_V.q = Eigen::AngleAxisd(0.5, Eigen::Vector3d::UnitZ());
  EXPECT_EQ(shelf.Add(view, keyframes_), ViewOutcome::kUncertain) << "upright in the image";
  view.image = test::SyntheticImage(view.camera->width(), view.camera->height(), 3);
  EXPECT_EQ(shelf.Add(view, keyframes_), ViewOutcome::kDisagrees) << "extracted from the image";
  view.image = cv::Mat();
  for (Keypoint& keypoint : view.features.features.keypoints) {
    keypoint.angle = -0.5F;
  }
  // That it does not show what it says is another matter.
  EXPECT_EQ(shelf.Add(view, keyframes_), ViewOutcome::kDisagrees);
}

TEST_F(ViewShelfTest, DropsWhatDoesNotShowItsSource) {
  ViewShelf shelf = Make();
  EXPECT_EQ(shelf.Add(View(0, 0, 5), keyframes_), ViewOutcome::kDisagrees);
  VirtualView few = View(0, 1);
  few.features.features.keypoints.resize(29);
  few.features.features.descriptors.resize(29);
  few.features.depth_m.resize(29);
  few.features.depth_sigma_m.resize(29);
  EXPECT_EQ(shelf.Add(few, keyframes_), ViewOutcome::kUncertain);
  few.features.depth_m.pop_back();
  EXPECT_THROW(shelf.Add(few, keyframes_), InputError);
  EXPECT_EQ(shelf.counts().disagree, 1);
  EXPECT_EQ(shelf.counts().uncertain, 1);
  EXPECT_EQ(shelf.counts().refused, 1);
  EXPECT_THAT(Indices(shelf, 0), IsEmpty());
}

TEST_F(ViewShelfTest, BeginsAnewWithALoadedMapsViews) {
  ViewShelf shelf = Make();
  for (const int index : {0, 1, 2}) {
    shelf.Add(View(0, index), keyframes_);
  }
  shelf.Add(View(9, 0), keyframes_);
  std::vector<StoredView> views = shelf.Of(0);
  options_.keep = 2;
  ViewShelf other = Make();
  other.Add(View(9, 0), keyframes_);
  places_.Clear();
  other.Clear();
  other.Restore(0, std::move(views));
  EXPECT_THAT(Indices(other, 0), ElementsAre(0, 1)) << "as many as are kept";
  EXPECT_EQ(other.Of(0)[0].camera, other.Of(0)[1].camera) << "held once";
  EXPECT_EQ(other.counts().kept, 2);
  EXPECT_EQ(other.counts().received, 0);
  EXPECT_EQ(other.counts().waiting, 1) << "its keyframe may still come";
}

TEST_F(ViewShelfTest, KeepsNoneWhenToldSo) {
  options_.keep = 0;
  ViewShelf shelf = Make();
  EXPECT_EQ(shelf.Add(View(0, 0), keyframes_), ViewOutcome::kSurpassed);
  EXPECT_EQ(shelf.counts().surpassed, 1);
}

}  // namespace
}  // namespace deja_view
