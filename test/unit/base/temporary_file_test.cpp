#include "deja_view/base/temporary_file.hpp"

#include "deja_view/base/atomic_file.hpp"
#include "deja_view/base/check.hpp"

#include <array>
#include <fstream>
#include <optional>
#include <set>
#include <string>

#include <gtest/gtest.h>
#include <sys/wait.h>
#include <unistd.h>

namespace deja_view {
namespace {

namespace fs = std::filesystem;

class TemporaryFileTest : public ::testing::Test {
 protected:
  void SetUp() override { fs::remove_all(directory_); }
  void TearDown() override { fs::remove_all(directory_); }

  // As a process leaves it that is killed while it writes.
  void Abandon(const fs::path& target) const {
    const pid_t child = ::fork();
    if (child == 0) {
      const TemporaryFile temporary(target);
      std::ofstream(temporary.path()) << "half";
      ::_exit(0);
    }
    ASSERT_EQ(::waitpid(child, nullptr, 0), child);
    ASSERT_TRUE(fs::exists(target.string() + ".deja_view_tmp" + std::to_string(child)));
  }

  std::set<std::string> Names() const {
    std::set<std::string> names;
    for (const auto& entry : fs::directory_iterator(directory_)) {
      names.insert(entry.path().filename().string());
    }
    return names;
  }

  fs::path directory_ = fs::path(::testing::TempDir()) / "deja_view_temporary_file_test";
};

TEST_F(TemporaryFileTest, GoesUnlessItIsRenamed) {
  {
    const TemporaryFile temporary(directory_ / "a");
    EXPECT_TRUE(fs::exists(temporary.path()));
  }
  EXPECT_TRUE(fs::is_empty(directory_));
  {
    TemporaryFile temporary(directory_ / "a");
    std::ofstream(temporary.path()) << "whole";
    temporary.Rename();
  }
  EXPECT_EQ(Names(), std::set<std::string>{"a"});
  EXPECT_EQ(fs::file_size(directory_ / "a"), 5U);
}

TEST_F(TemporaryFileTest, TheNextOneTakesAwayWhatAKilledProcessLeft) {
  Abandon(directory_ / "map.dvm");
  Abandon(directory_ / "other.dvm");
  EXPECT_EQ(Names().size(), 2U);
  WriteFileAtomically(directory_ / "map.dvm", [](std::ostream& out) { out << "x"; });
  EXPECT_EQ(Names().count("map.dvm"), 1U);
  EXPECT_EQ(Names().size(), 2U);  // the other target's is still there
  RemoveLeftovers(directory_);
  EXPECT_EQ(Names(), std::set<std::string>{"map.dvm"});
}

TEST_F(TemporaryFileTest, LeavesAloneWhatIsNotLeftOver) {
  std::optional<TemporaryFile> alive(directory_ / "alive");
  const fs::path held = alive->path();
  for (const char* name : {"notes.tmp1", "a.deja_view_tmp", "a.deja_view_tmp12x"}) {
    std::ofstream(directory_ / name) << "mine";
  }
  fs::create_directory(directory_ / "b.deja_view_tmp1");
  fs::create_symlink("notes.tmp1", directory_ / "c.deja_view_tmp1");
  const auto before = Names();
  RemoveLeftovers(directory_);
  EXPECT_EQ(Names(), before);
  EXPECT_TRUE(fs::exists(held));
}

TEST_F(TemporaryFileTest, TellsWhatCannotBeWritten) {
  fs::create_directories(directory_ / "taken");
  TemporaryFile temporary(directory_ / "taken");
  EXPECT_THROW(temporary.Rename(), InputError);
  EXPECT_THROW(TemporaryFile("/proc/nowhere/x"), InputError);
}

}  // namespace
}  // namespace deja_view
