#include "deja_view/fusion/model_directory.hpp"

#include <fstream>

#include "bag_fixture.hpp"
#include <gmock/gmock.h>

namespace deja_view {
namespace {

namespace fs = std::filesystem;
using ::testing::AllOf;
using ::testing::HasSubstr;

class ModelDirectoryTest : public BagTest {
 protected:
  ModelDirectoryTest() {
    fs::create_directories(Path("models/folder"));
    std::ofstream(Path("models/hall.dvn")) << "x";
    std::ofstream(Path("models/other")) << "x";
    std::ofstream(Path("secret.dvn")) << "x";
    fs::create_symlink(Path("secret.dvn"), Path("models/link.dvn"));
  }
  ModelDirectory models_{Path("models")};
};

TEST_F(ModelDirectoryTest, FindsFilesByName) {
  EXPECT_EQ(models_.Resolve("hall"), Path("models/hall.dvn"));
  EXPECT_EQ(models_.Resolve("hall.dvn"), Path("models/hall.dvn"));
  EXPECT_EQ(models_.Resolve("other"), Path("models/other"));
}

TEST_F(ModelDirectoryTest, DoesNotLeaveItsDirectory) {
  for (const std::string name : {"", "..", "../secret", "/etc/passwd", "a\\b", ".hidden", "a\nb"}) {
    EXPECT_THAT(ErrorOf([&] { models_.Resolve(name); }), HasSubstr("model name")) << name;
  }
  EXPECT_THAT(ErrorOf([&] { models_.Resolve("link"); }), HasSubstr("is a link"));
}

TEST_F(ModelDirectoryTest, ListsWhatIsThere) {
  EXPECT_THAT(ErrorOf([&] { models_.Resolve("room"); }),
              AllOf(HasSubstr("model 'room'"), HasSubstr("hall, link")));
  EXPECT_THAT(ErrorOf([&] { models_.Resolve("folder"); }), HasSubstr("expected one of"));
  EXPECT_THAT(ErrorOf([&] { ModelDirectory(Path("nowhere")).Resolve("x"); }),
              HasSubstr("no models at all"));
}

}  // namespace
}  // namespace deja_view
