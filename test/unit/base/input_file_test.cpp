#include "deja_view/base/input_file.hpp"

#include "deja_view/base/binary_stream.hpp"

#include <string>

#include "temporary_directory.hpp"
#include <gtest/gtest.h>
#include <sys/stat.h>

namespace deja_view {
namespace {

constexpr BinaryFormat kFormat = {{'T', 'E', 'S', 'T', 0, 0, 0, 0}, 1, "a test"};

class InputFileTest : public TemporaryDirectoryTest {
 protected:
  static void ExpectRefused(const std::filesystem::path& path, const std::string& why) {
    const std::string expected = path.string() + ": " + why;
    EXPECT_EQ(MessageOf<InputError>([&] { OpenInputFile(path); }), expected);
    EXPECT_EQ(MessageOf<InputError>([&] { Hash64OfFile(path); }), expected);
    EXPECT_EQ(MessageOf<InputError>([&] { BinaryReader(path, kFormat); }), expected);
  }
};

TEST_F(InputFileTest, OpensAFile) {
  std::string line;
  std::ifstream stream = OpenInputFile(Write("a.txt", "hello"));
  std::getline(stream, line);
  EXPECT_EQ(line, "hello");
}

TEST_F(InputFileTest, RefusesWhatIsNoFileInTheSystemsWords) {
  ExpectRefused(directory_ / "none", "can't be opened: No such file or directory");
  ExpectRefused(Write("a.txt", "x") / "b", "can't be opened: Not a directory");
  ExpectRefused(directory_, "is a directory: expected a file");
}

TEST_F(InputFileTest, DoesNotWaitForAPipe) {
  const std::filesystem::path path = directory_ / "pipe";
  ASSERT_EQ(::mkfifo(path.c_str(), 0600), 0);
  ExpectRefused(path, "is a pipe: expected a file");
  ExpectRefused("/dev/null", "is a device or socket: expected a file");
}

}  // namespace
}  // namespace deja_view
