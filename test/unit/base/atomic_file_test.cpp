#include "deja_view/base/atomic_file.hpp"

#include "deja_view/base/check.hpp"

#include <fstream>
#include <iterator>
#include <stdexcept>
#include <string>

#include <gtest/gtest.h>

namespace deja_view {
namespace {

namespace fs = std::filesystem;

class AtomicFileTest : public ::testing::Test {
 protected:
  void SetUp() override { fs::remove_all(directory_); }
  void TearDown() override { fs::remove_all(directory_); }

  std::string Read(const fs::path& path) const {
    std::ifstream stream(path, std::ios::binary);
    return {std::istreambuf_iterator<char>(stream), {}};
  }
  std::ptrdiff_t FileCount() const {
    return std::distance(fs::directory_iterator(directory_), fs::directory_iterator());
  }

  fs::path directory_ = fs::path(::testing::TempDir()) / "deja_view_atomic_file_test";
};

TEST_F(AtomicFileTest, CreatesParentsAndReplaces) {
  const fs::path path = directory_ / "a" / "b.txt";
  WriteFileAtomically(path, [](std::ostream& out) { out << "old"; });
  WriteFileAtomically(path, [](std::ostream& out) { out << "new"; });
  EXPECT_EQ(Read(path), "new");
}

TEST_F(AtomicFileTest, KeepsTheOldFileWhenTheWriterThrows) {
  const fs::path path = directory_ / "b.txt";
  WriteFileAtomically(path, [](std::ostream& out) { out << "old"; });
  EXPECT_THROW(WriteFileAtomically(path,
                                   [](std::ostream& out) {
                                     out << "half";
                                     throw std::runtime_error("interrupted");
                                   }),
               std::runtime_error);
  EXPECT_EQ(Read(path), "old");
  EXPECT_EQ(FileCount(), 1);
}

TEST_F(AtomicFileTest, NamesAPathThatCannotBeWritten) {
  fs::create_directories(directory_ / "taken");
  try {
    WriteFileAtomically(directory_ / "taken", [](std::ostream& out) { out << "x"; });
    FAIL() << "no exception";
  } catch (const InputError& e) {
    EXPECT_NE(std::string(e.what()).find("taken"), std::string::npos);
  }
  EXPECT_EQ(FileCount(), 1);
}

}  // namespace
}  // namespace deja_view
