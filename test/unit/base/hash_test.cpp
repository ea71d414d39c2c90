#include "deja_view/base/hash.hpp"

#include "deja_view/base/check.hpp"

#include <string>

#include "temporary_directory.hpp"
#include <gtest/gtest.h>

namespace deja_view {
namespace {

TEST(Hash64Test, IsXxh64) {
  EXPECT_EQ(Hash64(""), 0xEF46DB3751D8E999U);  // of xxHash's specification
  EXPECT_EQ(Hash64("abc"), 0x44BC2CF5AD770999U);
}

TEST(Hash64Test, PiecesGiveTheSameAsTheWhole) {
  const std::string text = "what was hashed in pieces of any length, more than thirty-two bytes";
  for (std::size_t cut = 0; cut <= text.size(); ++cut) {
    Hasher64 hasher;
    hasher.Add(text.data(), cut);
    hasher.Add(text.data() + cut, text.size() - cut);
    EXPECT_EQ(hasher.value(), Hash64(text)) << cut;
  }
  EXPECT_EQ(Hasher64().value(), Hash64(""));
}

class Hash64OfFileTest : public TemporaryDirectoryTest {};

TEST_F(Hash64OfFileTest, IsThatOfTheBytes) {
  const std::string text(100000, 'x');
  EXPECT_EQ(Hash64OfFile(Write("file", text)), Hash64(text));
  EXPECT_EQ(Hash64OfFile(Write("empty", "")), Hash64(""));
}

TEST_F(Hash64OfFileTest, NeedsAFile) {
  EXPECT_THROW(Hash64OfFile(directory_ / "none"), InputError);
  EXPECT_THROW(Hash64OfFile(directory_), InputError);
}

}  // namespace
}  // namespace deja_view
