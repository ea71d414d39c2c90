#include "deja_view/fusion/map_directory.hpp"

#include "deja_view/base/check.hpp"

#include <filesystem>
#include <fstream>
#include <string>

#include <gmock/gmock.h>
#include <gtest/gtest.h>
#include <unistd.h>

namespace deja_view {
namespace {

namespace fs = std::filesystem;
using ::testing::AllOf;
using ::testing::HasSubstr;

class MapDirectoryTest : public ::testing::Test {
 protected:
  void SetUp() override { fs::create_directories(root_); }
  void TearDown() override { fs::remove_all(root_.parent_path()); }

  std::string ErrorOf(const std::string& name) const {
    try {
      return "no InputError: " + maps_.ResolveExisting(name).string();
    } catch (const InputError& e) {
      return e.what();
    }
  }

  fs::path root_ = fs::path(::testing::TempDir()) /
                   ("deja_view_map_directory_test" + std::to_string(::getpid())) / "maps";
  MapDirectory maps_{root_};
};

TEST_F(MapDirectoryTest, ResolvesPlainNames) {
  EXPECT_EQ(maps_.Resolve("hall_3"), root_ / "hall_3");
  EXPECT_EQ(maps_.Resolve("Halle 3 (süd).v2"), root_ / "Halle 3 (süd).v2");
  fs::create_directories(root_ / "hall_3" / "part");
  EXPECT_EQ(maps_.ResolveExisting("hall_3"), root_ / "hall_3");
}

TEST_F(MapDirectoryTest, RefusesNamesThatLeadOut) {
  for (const std::string& name : {std::string(),
                                  std::string("."),
                                  std::string(".."),
                                  std::string(".hidden"),
                                  std::string("/tmp"),
                                  std::string("a/b"),
                                  std::string("../a"),
                                  std::string("a\\b"),
                                  std::string("a\0b", 3),
                                  std::string("a\nb"),
                                  std::string("-rf"),
                                  std::string(" a"),
                                  std::string("$(id)"),
                                  std::string("a;b"),
                                  std::string("a`b"),
                                  std::string("a*"),
                                  std::string("~a"),
                                  std::string("a\"b"),
                                  std::string(129, 'a')}) {
    EXPECT_THAT(ErrorOf(name), HasSubstr("map name '")) << name;
  }
}

TEST_F(MapDirectoryTest, RefusesLinksAndFiles) {
  fs::create_directory_symlink("/tmp", root_ / "out");
  EXPECT_THAT(ErrorOf("out"), HasSubstr("is a link"));
  fs::create_directories(root_ / "map");
  fs::create_symlink("/etc/passwd", root_ / "map" / "keyframes");
  EXPECT_THAT(ErrorOf("map"), HasSubstr("is a link"));
  std::ofstream(root_ / "file") << "x";
  EXPECT_THAT(ErrorOf("file"), HasSubstr("is no directory"));
}

TEST_F(MapDirectoryTest, ListsTheMapsThatAreThere) {
  EXPECT_THAT(ErrorOf("hall"), HasSubstr("no maps at all"));
  fs::create_directories(root_ / "b");
  fs::create_directories(root_ / "a");
  EXPECT_THAT(ErrorOf("hall"), AllOf(HasSubstr("'hall'"), HasSubstr("one of a, b")));
}

}  // namespace
}  // namespace deja_view
