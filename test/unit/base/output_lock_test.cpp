#include "deja_view/base/output_lock.hpp"

#include "deja_view/base/check.hpp"

#include <fstream>
#include <string>

#include <gtest/gtest.h>
#include <sys/wait.h>
#include <unistd.h>

namespace deja_view {
namespace {

namespace fs = std::filesystem;

class OutputLockTest : public ::testing::Test {
 protected:
  void SetUp() override { fs::remove_all(directory_); }
  void TearDown() override { fs::remove_all(directory_); }

  std::string ErrorOfLocking() const {
    try {
      OutputLock::OfDirectory(directory_);
    } catch (const InputError& e) {
      return e.what();
    }
    return {};
  }

  fs::path directory_ = fs::path(::testing::TempDir()) / "deja_view_output_lock_test";
};

TEST_F(OutputLockTest, KeepsOthersAwayAndTellsWhoHasIt) {
  {
    const OutputLock lock = OutputLock::OfDirectory(directory_);
    const std::string error = ErrorOfLocking();
    EXPECT_NE(error.find(directory_.string() + ": another process"), std::string::npos) << error;
    EXPECT_NE(error.find(std::to_string(::getpid())), std::string::npos) << error;
    EXPECT_THROW(OutputLock::OfDirectory(directory_), InputError);
  }
  EXPECT_TRUE(fs::is_empty(directory_));
  EXPECT_EQ(ErrorOfLocking(), "");
}

TEST_F(OutputLockTest, AKilledProcessHoldsNothing) {
  const pid_t child = ::fork();
  if (child == 0) {
    const OutputLock lock = OutputLock::OfDirectory(directory_);
    ::_exit(0);
  }
  ASSERT_EQ(::waitpid(child, nullptr, 0), child);
  EXPECT_FALSE(fs::is_empty(directory_));
  EXPECT_EQ(ErrorOfLocking(), "");
  EXPECT_TRUE(fs::is_empty(directory_));
}

TEST_F(OutputLockTest, FilesAreLockedOneByOne) {
  const OutputLock a = OutputLock::OfFile(directory_ / "a.bag");
  const OutputLock b = OutputLock::OfFile(directory_ / "b.bag");
  EXPECT_THROW(OutputLock::OfFile(directory_ / "a.bag"), InputError);
  EXPECT_EQ(ErrorOfLocking(), "");
}

TEST_F(OutputLockTest, NamesWhatCannotBeWritten) {
  fs::create_directories(directory_);
  std::ofstream(directory_ / "file") << "x";
  EXPECT_THROW(OutputLock::OfDirectory(directory_ / "file"), InputError);
  EXPECT_THROW(OutputLock::OfFile(directory_ / "file" / "x"), InputError);
}

}  // namespace
}  // namespace deja_view
