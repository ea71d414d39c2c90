#include "deja_view/io/image_files.hpp"

#include "deja_view/base/check.hpp"

#include "temporary_directory.hpp"
#include <gmock/gmock.h>

namespace deja_view {
namespace {

class ImageFilesTest : public TemporaryDirectoryTest {
 protected:
  std::string Error() const {
    return MessageOf<InputError>([&] { ListStampedImages(directory_); });
  }
};

TEST_F(ImageFilesTest, ComeInTheOrderOfTheirStamps) {
  Write("100.000000002.PNG", "");
  Write("99000000001.jpg", "");  // sorts behind by name
  Write("99000000001.depth.png", "");
  Write("notes.txt", "");
  Write("below/1.png", "");
  const std::vector<StampedImage> images = ListStampedImages(directory_);
  ASSERT_EQ(images.size(), 2U);
  EXPECT_EQ(images[0].stamp_ns, 99'000'000'001);
  EXPECT_EQ(images[1].stamp_ns, 100'000'000'002);
  EXPECT_EQ(images[1].path, directory_ / "100.000000002.PNG");
}

TEST_F(ImageFilesTest, AreFoundInEurocsFolders) {
  const auto path = Write("mav0/cam0/data/1403636579763555584.png", "");
  Write("mav0/cam0/data.csv", "#timestamp [ns],filename\n");
  const std::vector<StampedImage> images = ListStampedImages(directory_);
  ASSERT_EQ(images.size(), 1U);
  EXPECT_EQ(images[0].stamp_ns, 1403636579763555584);
  EXPECT_EQ(images[0].path, path);
}

TEST_F(ImageFilesTest, ErrorsNameTheFile) {
  EXPECT_THAT(Error(), Says(directory_.string(), "holds no image"));
  Write("1000000000.png", "");
  Write("1.png.jpg", "");
  EXPECT_THAT(Error(), Says("1.png.jpg", "expected a stamp"));
  std::filesystem::remove(directory_ / "1.png.jpg");
  Write("1.000000000.png", "");
  EXPECT_THAT(Error(), Says("/1000000000.png", "1.000000000.png too"));
  EXPECT_THAT(MessageOf<InputError>([&] { ListStampedImages(directory_ / "nowhere"); }),
              Says("nowhere", "can't be listed"));
}

}  // namespace
}  // namespace deja_view
