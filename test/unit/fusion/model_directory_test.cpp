#include "deja_view/fusion/model_directory.hpp"

#include "deja_view/base/check.hpp"

#include <fstream>

#include "temporary_directory.hpp"
#include <gmock/gmock.h>

namespace deja_view {
namespace {

namespace fs = std::filesystem;

class ModelDirectoryTest : public TemporaryDirectoryTest {
 protected:
  ModelDirectoryTest() {
    fs::create_directories(Path("models/folder"));
    std::ofstream(Path("models/hall.dvn")) << "x";
    std::ofstream(Path("models/other")) << "x";
    std::ofstream(Path("secret.dvn")) << "x";
    fs::create_symlink(Path("secret.dvn"), Path("models/link.dvn"));
  }
  fs::path Path(const std::string& name) const { return directory_ / name; }

  ModelDirectory models_{Path("models")};
};

TEST_F(ModelDirectoryTest, FindsFilesByName) {
  EXPECT_EQ(models_.Resolve("hall"), Path("models/hall.dvn"));
  EXPECT_EQ(models_.Resolve("hall.dvn"), Path("models/hall.dvn"));
  EXPECT_EQ(models_.Resolve("other"), Path("models/other"));
}

TEST_F(ModelDirectoryTest, DoesNotLeaveItsDirectory) {
  for (const std::string name : {"", "..", "../secret", "/etc/passwd", "a\\b", ".hidden", "a\nb"}) {
    EXPECT_THAT(MessageOf<InputError>([&] { models_.Resolve(name); }), Says("model name")) << name;
  }
  EXPECT_THAT(MessageOf<InputError>([&] { models_.Resolve("link"); }), Says("is a link"));
}

TEST_F(ModelDirectoryTest, ListsWhatIsThere) {
  EXPECT_THAT(MessageOf<InputError>([&] { models_.Resolve("room"); }),
              Says("model 'room'", "hall, link"));
  EXPECT_THAT(MessageOf<InputError>([&] { models_.Resolve("folder"); }), Says("expected one of"));
  EXPECT_THAT(MessageOf<InputError>([&] { ModelDirectory(Path("nowhere")).Resolve("x"); }),
              Says("no models at all"));
}

}  // namespace
}  // namespace deja_view
