#include "deja_view/base/binary_stream.hpp"

#include <fstream>
#include <iterator>

#include "temporary_directory.hpp"
#include <gmock/gmock.h>
#include <gtest/gtest.h>

namespace deja_view {
namespace {

namespace fs = std::filesystem;
using testing::HasSubstr;

constexpr BinaryFormat kFormat{{'D', 'V', 'T', 'E', 'S', 'T', '\r', '\n'}, 3, "a test"};

struct Options {
  int count = 0;
  bool is_on = false;
  template <typename V>
  void Visit(V& v) {
    v("count", count);
    v("is_on", is_on);
  }
};

class BinaryStreamTest : public TemporaryDirectoryTest {
 protected:
  fs::path WriteSample() const {
    WriteBinaryFile(path_, kFormat, [](BinaryWriter* out) {
      Options options{7, true};
      options.Visit(*out);
      out->WriteAll(std::vector<double>{1.5, -2});
      out->WriteAll(std::string("name"));
      out->Write(std::int64_t{-5});
    });
    return path_;
  }
  std::string Bytes() const {
    std::ifstream stream(path_, std::ios::binary);
    return {std::istreambuf_iterator<char>(stream), {}};
  }
  std::string Refusal(const BinaryFormat& format = kFormat) const {
    return MessageOf<InputError>([&] { BinaryReader(path_, format); });
  }

  fs::path path_ = directory_ / "file";
};

TEST_F(BinaryStreamTest, ComesBack) {
  BinaryReader in(WriteSample(), kFormat);
  Options options;
  options.Visit(in);
  EXPECT_EQ(options.count, 7);
  EXPECT_TRUE(options.is_on);
  EXPECT_EQ(in.ReadAll<double>("doubles"), (std::vector<double>{1.5, -2}));
  const std::vector<char> name = in.ReadAll<char>("name");
  EXPECT_EQ(std::string(name.begin(), name.end()), "name");
  EXPECT_EQ(in.left(), 8U);
  EXPECT_THROW(in.Finish(), InputError);
  EXPECT_EQ(in.Read<std::int64_t>("last"), -5);
  EXPECT_NO_THROW(in.Finish());
  EXPECT_THROW(in.Read<char>("more"), InputError);
}

TEST_F(BinaryStreamTest, EveryFlippedBitAndEveryCutIsAnError) {
  WriteSample();
  const std::string bytes = Bytes();
  EXPECT_EQ(Refusal(), "no error");
  for (std::size_t i = 0; i < bytes.size(); ++i) {
    std::string damaged = bytes;
    damaged[i] = static_cast<char>(damaged[i] ^ 0x10);
    Write("file", damaged);
    EXPECT_THAT(Refusal(), HasSubstr(path_.string())) << i;
    Write("file", bytes.substr(0, i));
    EXPECT_THAT(Refusal(), HasSubstr(path_.string())) << i;
  }
  Write("file", bytes + '\0');
  EXPECT_THAT(Refusal(), HasSubstr("says"));
}

TEST_F(BinaryStreamTest, SaysWhatIsWrong) {
  EXPECT_THAT(Refusal(), HasSubstr("can't be opened"));
  WriteSample();
  BinaryFormat other = kFormat;
  other.version = other.oldest = 4;
  EXPECT_THAT(Refusal(other), HasSubstr("version 3, expected 4"));
  other.magic[0] = 'X';
  EXPECT_THAT(Refusal(other), HasSubstr("is not a test"));
}

TEST_F(BinaryStreamTest, ReadsOlderVersionsThatItKnows) {
  WriteSample();
  BinaryFormat newer = kFormat;
  newer.version = 5;
  newer.oldest = 3;
  EXPECT_EQ(BinaryReader(path_, newer).version(), 3U);
  newer.oldest = 4;
  EXPECT_THAT(Refusal(newer), HasSubstr("version 3, expected 4 to 5"));
}

TEST_F(BinaryStreamTest, PassesOverWhatIsNotNeeded) {
  BinaryReader in(WriteSample(), kFormat);
  in.Skip(in.left() - sizeof(std::int64_t), "all but the last");
  EXPECT_EQ(in.Read<std::int64_t>("last"), -5);
  EXPECT_THROW(in.Skip(1, "more"), InputError);
}

TEST_F(BinaryStreamTest, AllocatesNoMoreThanTheFileHolds) {
  WriteBinaryFile(path_, kFormat, [](BinaryWriter* out) { out->Write(~std::uint64_t{0}); });
  BinaryReader in(path_, kFormat);
  EXPECT_THROW(in.ReadAll<double>("forged"), InputError);
}

TEST_F(BinaryStreamTest, ASwitchIsOnOrOff) {
  WriteBinaryFile(path_, kFormat, [](BinaryWriter* out) { out->Write(std::uint8_t{2}); });
  BinaryReader in(path_, kFormat);
  EXPECT_THROW(in.Read<bool>("switch"), InputError);
}

}  // namespace
}  // namespace deja_view
