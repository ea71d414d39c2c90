// Saved maps; after a first byte of 1 with the hash of what they hold.
#include "deja_view/pipeline/loop_closer.hpp"

#include <optional>

#include "fuzz.hpp"
#include "random_vocabulary.hpp"
#include "synthetic_image.hpp"
#include "test_cameras.hpp"

namespace deja_view::fuzz {
namespace {

constexpr int kWidth = 160;
constexpr int kHeight = 120;

LoopCloser MakeCloser() {
  static const auto vocabulary = Vocabulary::FromTree(test::RandomTree(3, 3, 1, 4));
  LoopCloserOptions options;
  options.features.brief.max_features = 20;
  options.map_spacing_m = 0;
  const auto camera = SharedPinholeOf(kWidth, kHeight, 100, 80, 60);
  return {options, camera, Rigid3::Identity(), vocabulary};
}

KeyframeInput Keyframe(int i) {
  KeyframeInput keyframe;
  keyframe.stamp_ns = 1'000'000'000LL * (i + 1);
  keyframe.T_W_B.t.x() = 0.5 * i;
  keyframe.image = test::SyntheticImage(kWidth, kHeight, static_cast<std::uint64_t>(i + 1));
  for (int j = 0; j < 6; ++j) {
    TrackedPoint point;
    point.p_W = {0.1 * j, 0.2, 3};
    point.pixel = {20.0F + 10.0F * static_cast<float>(j), 40.0F};
    point.feature_id = j;
    keyframe.points.push_back(point);
  }
  return keyframe;
}

}  // namespace

std::vector<std::string> Seeds() {
  LoopCloser closer = MakeCloser();
  std::vector<std::string> seeds;
  for (int i = 0; i < 3; ++i) {
    closer.AddKeyframe(Keyframe(i));
    if (i == 2) {
      VirtualView view;
      view.stamp_ns = Keyframe(2).stamp_ns;
      view.count = 1;
      view.T_C_V.t.x() = 0.1;
      view.camera = SharedPinholeOf(kWidth, kHeight, 100, 80, 60);
      view.image = Keyframe(2).image;
      closer.AddVirtualView(view);
    }
    closer.Save(Scratch() / "seed");
    seeds.push_back('\1' + ReadAll(Scratch() / "seed" / "map.dvm"));
  }
  return seeds;
}

void RunOne(const std::string& input) {
  auto [prefix, file] = SplitPrefix(input);
  if (prefix == 1) {
    Seal(&file);
  }
  Write("map/map.dvm", file);
  LoopCloser closer = MakeCloser();
  closer.Load(Scratch() / "map");
  closer.AddKeyframe(Keyframe(3));
  closer.OptimizeFully();
}

}  // namespace deja_view::fuzz
