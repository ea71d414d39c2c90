#include "deja_view/features/brief_pattern.hpp"
#include "deja_view/fusion/loop_fusion_options.hpp"
#include "deja_view/io/options_yaml.hpp"
#include "deja_view/io/vins_config.hpp"
#include "deja_view/views/view_maker.hpp"
#include "deja_view/vocabulary/vocabulary.hpp"

#include <filesystem>
#include <string>

#include <gtest/gtest.h>

namespace deja_view {
namespace {

namespace fs = std::filesystem;

const fs::path kConfig = DEJA_VIEW_SOURCE_CONFIG;

TEST(ShippedConfigTest, OptionsAreTheDefaults) {
  EXPECT_EQ(OptionsToYaml(ReadOptions<LoopFusionOptions>(kConfig / "loop_fusion.yaml")),
            OptionsToYaml(LoopFusionOptions()));
}

TEST(ShippedConfigTest, ViewPresetsLoad) {
  const auto paper = ReadOptions<ViewOptions>(kConfig / "views_paper.yaml");
  EXPECT_EQ(paper.sampling.radius_m, 0.02);
  const auto wide = ReadOptions<ViewOptions>(kConfig / "views_wide.yaml");
  EXPECT_EQ(wide.sampling.rotation_deg, 30);
  EXPECT_EQ(wide.sources.against, SourceSpacing::kAll);
  const auto needed = ReadOptions<ViewOptions>(kConfig / "views_needed.yaml");
  EXPECT_EQ(needed.choice.by, ChoiceKind::kNeed);
  EXPECT_EQ(needed.sampling.radius_m, 3);
}

/// Counts how often a field is visited, whatever it is.
struct FieldCounter {
  template <typename T>
  void operator()(const char* /*key*/, T& field) {
    if constexpr (internal::HasVisit<T>::value) {
      field.Visit(*this);
    } else {
      ++count;
    }
  }
  int count = 0;
};

int CountScalars(const ConfigNode& node) {
  if (node.kind != ConfigNode::Kind::kMap) {
    return 1;
  }
  int count = 0;
  for (const auto& [key, child] : node.entries) {
    count += CountScalars(child);
  }
  return count;
}

TEST(ShippedConfigTest, OptionsNameEveryKey) {
  LoopFusionOptions options;
  FieldCounter counter;
  options.Visit(counter);
  EXPECT_EQ(CountScalars(ReadConfigFile(kConfig / "loop_fusion.yaml")), counter.count);
}

TEST(ShippedConfigTest, CameraFilesLoad) {
  const VinsConfig vins = ReadVinsConfig(kConfig / "euroc.yaml");
  EXPECT_EQ(vins.image_topic, "/cam0/image_raw");
  EXPECT_EQ(vins.camera->width(), 752);
}

TEST(ShippedConfigTest, BriefPatternIsTheBuiltIn) {
  EXPECT_EQ(ReadBriefPattern(kConfig / "brief_pattern.yml").pairs, DefaultBriefPattern().pairs);
}

TEST(ShippedConfigTest, VocabulariesLoad) {
  for (const std::string name : {"brief", "orb"}) {
    const auto vocabulary = Vocabulary::Open(kConfig / "vocabulary" / (name + ".dvv"));
    EXPECT_EQ(vocabulary->descriptor_name(), name);
    EXPECT_GT(vocabulary->word_count(), 10'000U);
  }
}

TEST(ShippedConfigTest, EveryFileIsTested) {
  for (const auto& entry : fs::recursive_directory_iterator(kConfig)) {
    const std::string name = entry.path().filename().string();
    const std::string extension = entry.path().extension().string();
    const bool is_known = entry.is_directory() || extension == ".md" || extension == ".rviz" ||
                          name == "loop_fusion.yaml" || name == "euroc.yaml" ||
                          name == "views_paper.yaml" || name == "views_wide.yaml" ||
                          name == "views_needed.yaml" || name == "brief_pattern.yml" ||
                          name == "brief.dvv" || name == "orb.dvv" ||
                          name == "fsrcnn_x2.onnx";  // super_resolution_test.cpp
    EXPECT_TRUE(is_known) << entry.path() << " needs a test here";
  }
}

}  // namespace
}  // namespace deja_view
