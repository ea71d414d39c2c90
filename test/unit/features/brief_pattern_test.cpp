#include "deja_view/features/brief_pattern.hpp"

#include "deja_view/base/check.hpp"

#include <fstream>
#include <string>

#include <gmock/gmock.h>
#include <gtest/gtest.h>
#include <unistd.h>

namespace deja_view {
namespace {

TEST(BriefPattern, DefaultFitsThePatch) {
  double squares = 0;
  for (const BriefPattern::Pair& pair : DefaultBriefPattern().pairs) {
    for (const int offset : {pair.x1, pair.y1, pair.x2, pair.y2}) {
      EXPECT_GE(offset, -24);
      EXPECT_LT(offset, 24);
      squares += offset * offset;
    }
    EXPECT_FALSE(pair.x1 == pair.x2 && pair.y1 == pair.y2);
  }
  EXPECT_NEAR(std::sqrt(squares / 1024), 9.3, 0.5);  // 48/5, a little less for the cut
  EXPECT_LE(DefaultBriefPattern().Radius(), 24);
}

TEST(BriefPattern, ShippedFileIsTheDefault) {
  EXPECT_EQ(ReadBriefPattern(DEJA_VIEW_SOURCE_DIR "/config/brief_pattern.yml").pairs,
            DefaultBriefPattern().pairs);
}

TEST(BriefPattern, BadFilesAreNamed) {
  const std::filesystem::path path = std::filesystem::temp_directory_path() /
                                     ("deja_view_pattern_" + std::to_string(::getpid()) + ".yml");
  const auto error = [&](const std::string& text) -> std::string {
    std::ofstream(path) << text;
    try {
      ReadBriefPattern(path);
    } catch (const InputError& e) {
      return e.what();
    }
    return "";
  };
  const auto list = [](const std::string& key, const std::string& value, int count) {
    std::string text = key + ":\n";
    for (int i = 0; i < count; ++i) {
      text += "   - " + value + "\n";
    }
    return text;
  };
  const std::string header = "%YAML:1.0\n";
  using ::testing::HasSubstr;
  EXPECT_THAT(error(header + "a: 1\n"), HasSubstr("key 'x1': expected a list of 256"));
  EXPECT_THAT(error(header + list("x1", "1", 255)), HasSubstr("found 255 entries"));
  EXPECT_THAT(error(header + list("x1", "1", 256) + list("y1", "1.5", 256)),
              HasSubstr("key 'y1', entry 0"));
  EXPECT_THAT(error(header + list("x1", "200", 256)), HasSubstr("key 'x1', entry 0"));
  EXPECT_THAT(error("nothing like it"), HasSubstr(path.string()));
  std::filesystem::remove(path);
  EXPECT_THROW(ReadBriefPattern(path), InputError);
}

}  // namespace
}  // namespace deja_view
