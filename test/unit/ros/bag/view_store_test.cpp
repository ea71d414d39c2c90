#include "deja_view/ros/bag/view_store.hpp"

#include <fstream>

#include <gtest/gtest.h>
#include <unistd.h>

namespace deja_view {
namespace {

namespace fs = std::filesystem;

class ViewStoreTest : public ::testing::Test {
 protected:
  ~ViewStoreTest() override { fs::remove_all(directory_); }

  static SourceResult MakeResult() {
    SourceResult result;
    result.stamp_ns = 1403636632538560256;
    result.recorded_ns = result.stamp_ns + 7;
    result.frames.resize(2);
    result.frames[0].image = {1, 2, 3};
    result.frames[1].view_index = 1;
    result.frames[1].u = {0.5F};
    result.not_free = 4;
    result.uncertain = 5;
    result.fit = {1.5, -0.1, 0.9, 30};
    result.elapsed_s = 0.25;
    return result;
  }

  fs::path directory_ =
      fs::path(::testing::TempDir()) / ("deja_view_store" + std::to_string(::getpid()));
  ViewStore store_{directory_, 77};
};

TEST_F(ViewStoreTest, GivesBackWhatWasWritten) {
  const SourceResult result = MakeResult();
  EXPECT_FALSE(store_.Read(result.stamp_ns));
  store_.Write(result);
  const auto back = store_.Read(result.stamp_ns);
  ASSERT_TRUE(back);
  EXPECT_EQ(back->recorded_ns, result.recorded_ns);
  ASSERT_EQ(back->frames.size(), 2U);
  EXPECT_EQ(back->frames[0].image, result.frames[0].image);
  EXPECT_EQ(back->frames[1].view_index, 1);
  EXPECT_EQ(back->frames[1].u, result.frames[1].u);
  EXPECT_TRUE(back->is_recognised);
  EXPECT_EQ(back->not_free, 4);
  EXPECT_EQ(back->uncertain, 5);
  EXPECT_EQ(back->fit.gain, 1.5);
  EXPECT_EQ(back->fit.psnr_db, 30);
  EXPECT_EQ(back->elapsed_s, 0.25);
  EXPECT_FALSE(store_.Read(result.stamp_ns + 1));
}

TEST_F(ViewStoreTest, PassesOverOtherSettingsAndDamage) {
  const SourceResult result = MakeResult();
  store_.Write(result);
  EXPECT_FALSE(ViewStore(directory_, 78).Read(result.stamp_ns));
  const fs::path path = fs::directory_iterator(directory_)->path();
  {
    std::fstream file(path, std::ios::in | std::ios::out | std::ios::binary);
    file.seekp(-3, std::ios::end);
    file.put('x');
  }
  EXPECT_FALSE(store_.Read(result.stamp_ns));
  store_.Write(result);
  EXPECT_TRUE(store_.Read(result.stamp_ns));
  fs::resize_file(path, fs::file_size(path) - 1);
  EXPECT_FALSE(store_.Read(result.stamp_ns));
  fs::resize_file(path, 10);
  EXPECT_FALSE(store_.Read(result.stamp_ns));
}

TEST_F(ViewStoreTest, PassesOverACountThatIsNotThatOfTheFrames) {
  const SourceResult result = MakeResult();
  for (const char count : {'\1', '\3', '\x7F'}) {
    store_.Write(result);
    std::fstream file(fs::directory_iterator(directory_)->path(),
                      std::ios::in | std::ios::out | std::ios::binary);
    file.seekp(92);  // at the end of the header
    file.put(count);
    file.close();
    EXPECT_FALSE(store_.Read(result.stamp_ns)) << static_cast<int>(count);
  }
}

TEST_F(ViewStoreTest, RemovesItsOwnFilesOnly) {
  store_.Write(MakeResult());
  std::ofstream(directory_ / "notes.txt") << "mine";
  store_.Remove();
  EXPECT_TRUE(fs::exists(directory_ / "notes.txt"));
  EXPECT_FALSE(store_.Read(MakeResult().stamp_ns));
  fs::remove(directory_ / "notes.txt");
  store_.Remove();
  EXPECT_FALSE(fs::exists(directory_));
}

}  // namespace
}  // namespace deja_view
