#pragma once

#include "deja_view/base/check.hpp"
#include "deja_view/vocabulary/vocabulary.hpp"

#include <filesystem>
#include <fstream>
#include <string>

#include <gmock/gmock.h>
#include <gtest/gtest.h>
#include <unistd.h>

namespace deja_view {

/// Tests on one vocabulary file, `path_`, in a folder of their own.
class VocabularyFileTest : public ::testing::Test {
 protected:
  explicit VocabularyFileTest(const std::string& name)
      : directory_(std::filesystem::path(::testing::TempDir()) /
                   ("deja_view_vocabulary_file_test" + std::to_string(::getpid()))),
        path_(directory_ / name) {}
  ~VocabularyFileTest() override { std::filesystem::remove_all(directory_); }

  void Write(const std::string& bytes) const {
    std::filesystem::create_directories(directory_);
    std::ofstream(path_, std::ios::binary) << bytes;
  }

  /// The file with these bytes is refused with an error that names it and `field`.
  void ExpectRefused(const std::string& bytes, const std::string& field) const {
    Write(bytes);
    try {
      Vocabulary::Open(path_);
      ADD_FAILURE() << "accepted, expected: " << field;
    } catch (const InputError& e) {
      EXPECT_THAT(e.what(), ::testing::HasSubstr(path_.string()));
      EXPECT_THAT(e.what(), ::testing::HasSubstr(field));
    }
  }

  std::filesystem::path directory_;
  std::filesystem::path path_;
};

}  // namespace deja_view
