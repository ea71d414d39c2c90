#include "deja_view/vocabulary/vocabulary_files.hpp"

#include "deja_view/base/check.hpp"
#include "deja_view/vocabulary/vocabulary.hpp"

#include <filesystem>
#include <fstream>

#include "random_vocabulary.hpp"
#include <gtest/gtest.h>
#include <unistd.h>

namespace deja_view {
namespace {

class VocabularyFilesTest : public ::testing::Test {
 protected:
  VocabularyFilesTest() { std::filesystem::create_directories(directory_); }
  ~VocabularyFilesTest() override { std::filesystem::remove_all(directory_); }

  std::filesystem::path directory_ =
      std::filesystem::path(::testing::TempDir()) /
      ("deja_view_vocabulary_files_test" + std::to_string(::getpid()));
};

TEST_F(VocabularyFilesTest, FormatsAreToldApartByContent) {
  const VocabularyTree tree = test::RandomTree(10, 1, 1);
  WriteFlatVocabulary(directory_ / "a", tree);
  WriteVinsVocabulary(directory_ / "b", tree);
  WriteOrbSlamVocabulary(directory_ / "c", tree);
  EXPECT_EQ(DetectVocabularyFormat(directory_ / "a"), VocabularyFormat::kFlat);
  EXPECT_EQ(DetectVocabularyFormat(directory_ / "b"), VocabularyFormat::kVins);
  EXPECT_EQ(DetectVocabularyFormat(directory_ / "c"), VocabularyFormat::kOrbSlam);
}

TEST_F(VocabularyFilesTest, TheExtensionChoosesTheFormat) {
  const VocabularyTree tree = test::RandomTree(4, 2, 1);
  WriteVocabulary(directory_ / "a.dvv", tree);
  WriteVocabulary(directory_ / "a.bin", tree);
  WriteVocabulary(directory_ / "a.txt", tree);
  EXPECT_EQ(DetectVocabularyFormat(directory_ / "a.dvv"), VocabularyFormat::kFlat);
  EXPECT_EQ(DetectVocabularyFormat(directory_ / "a.bin"), VocabularyFormat::kVins);
  EXPECT_EQ(DetectVocabularyFormat(directory_ / "a.txt"), VocabularyFormat::kOrbSlam);
  EXPECT_THROW(WriteVocabulary(directory_ / "a.yml", tree), InputError);
}

TEST_F(VocabularyFilesTest, RefusesWhatIsNoFile) {
  EXPECT_THROW(Vocabulary::Open(directory_ / "missing.dvv"), InputError);
  EXPECT_THROW(Vocabulary::Open(directory_), InputError);
  std::ofstream(directory_ / "empty.dvv").flush();
  EXPECT_THROW(Vocabulary::Open(directory_ / "empty.dvv"), InputError);
}

TEST_F(VocabularyFilesTest, VerifyNoticesDamage) {
  const auto path = directory_ / "a.dvv";
  WriteFlatVocabulary(path, test::RandomTree(4, 3, 1));
  EXPECT_NO_THROW(VerifyFlatVocabulary(path));
  std::fstream file(path, std::ios::binary | std::ios::in | std::ios::out);
  file.seekp(2000);
  file.put('\x55');
  file.put('\x55');
  file.close();
  EXPECT_THROW(VerifyFlatVocabulary(path), InputError);
  EXPECT_THROW(Vocabulary::Open(path), InputError);
}

}  // namespace
}  // namespace deja_view
