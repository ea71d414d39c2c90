#pragma once

#include <filesystem>
#include <fstream>
#include <string>

#include "error_messages.hpp"
#include <gtest/gtest.h>
#include <unistd.h>

namespace deja_view {

/// A fixture with an empty directory of its own, which goes when the test does.
class TemporaryDirectoryTest : public ::testing::Test {
 protected:
  TemporaryDirectoryTest() {
    const auto* test = ::testing::UnitTest::GetInstance()->current_test_info();
    directory_ = std::filesystem::temp_directory_path() /
                 (std::string("deja_view_") + test->test_suite_name() + "_" + test->name() + "_" +
                  std::to_string(::getpid()));
    std::filesystem::create_directories(directory_);
  }
  ~TemporaryDirectoryTest() override { std::filesystem::remove_all(directory_); }

  /// Writes a file below the directory, and the folders it needs; returns its path.
  std::filesystem::path Write(const std::filesystem::path& name, const std::string& content) const {
    std::filesystem::create_directories((directory_ / name).parent_path());
    std::ofstream(directory_ / name, std::ios::binary) << content;
    return directory_ / name;
  }

  std::filesystem::path directory_;
};

}  // namespace deja_view
