#include "deja_view/vocabulary/vocabulary_files.hpp"

#include "deja_view/base/check.hpp"
#include "deja_view/vocabulary/vocabulary.hpp"

#include <filesystem>
#include <fstream>

#include "random_vocabulary.hpp"
#include "temporary_directory.hpp"
#include <gtest/gtest.h>

namespace deja_view {
namespace {

class VocabularyFilesTest : public TemporaryDirectoryTest {
 protected:
  void ExpectFormats(const std::string& flat, const std::string& vins, const std::string& orb) {
    EXPECT_EQ(DetectVocabularyFormat(directory_ / flat), VocabularyFormat::kFlat);
    EXPECT_EQ(DetectVocabularyFormat(directory_ / vins), VocabularyFormat::kVins);
    EXPECT_EQ(DetectVocabularyFormat(directory_ / orb), VocabularyFormat::kOrbSlam);
  }
};

TEST_F(VocabularyFilesTest, FormatsAreToldApartByContent) {
  const VocabularyTree tree = test::RandomTree(10, 1, 1);
  WriteFlatVocabulary(directory_ / "a", tree);
  WriteVinsVocabulary(directory_ / "b", tree);
  WriteOrbSlamVocabulary(directory_ / "c", tree);
  ExpectFormats("a", "b", "c");
}

TEST_F(VocabularyFilesTest, TheExtensionChoosesTheFormat) {
  const VocabularyTree tree = test::RandomTree(4, 2, 1);
  for (const char* name : {"a.dvv", "a.bin", "a.txt"}) {
    WriteVocabulary(directory_ / name, tree);
  }
  ExpectFormats("a.dvv", "a.bin", "a.txt");
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
