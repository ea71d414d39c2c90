#include "deja_view/io/colmap.hpp"

#include "deja_view/base/check.hpp"

#include <cmath>
#include <cstring>
#include <limits>

#include "temporary_directory.hpp"
#include <gmock/gmock.h>

namespace deja_view {
namespace {

using ::testing::AllOf;
using ::testing::HasSubstr;

// Values as they lie in COLMAP's binary files.
class Bytes {
 public:
  template <typename T>
  Bytes& Add(T value) {
    char raw[sizeof(T)];
    std::memcpy(raw, &value, sizeof(T));
    text_.append(raw, sizeof(T));
    return *this;
  }
  Bytes& AddName(const std::string& name) {
    text_ += name + '\0';
    return *this;
  }
  const std::string& text() const { return text_; }

 private:
  std::string text_;
};

constexpr const char* kImages =
    "# IMAGE_ID, QW, QX, QY, QZ, TX, TY, TZ, CAMERA_ID, NAME\n"
    "7 0.70710678 0 0 0.70710678 1 2 3 4 b/second.jpg\n"
    "10.5 20.5 11 1 2 -1 3 4 99\n"
    "2 1 0 0 0 0 0 -5 4 a first.jpg\n"
    "\n";
constexpr const char* kPoints = "11 1 2 10 255 0 0 0.7 7 0 2 5\n";

class ColmapTest : public TemporaryDirectoryTest {
 protected:
  void WriteText(const std::string& cameras,
                 const std::string& images = kImages,
                 const std::string& points = kPoints) const {
    Write("cameras.txt", cameras);
    Write("images.txt", images);
    Write("points3D.txt", points);
  }
  std::string TextError(const std::string& cameras,
                        const std::string& images = kImages,
                        const std::string& points = kPoints) const {
    WriteText(cameras, images, points);
    return MessageOf<InputError>([&] { ReadColmapModel(directory_); });
  }

  static std::string BinaryCameras() {
    return Bytes()
        .Add(std::uint64_t{1})
        .Add(std::uint32_t{4})
        .Add(std::int32_t{1})
        .Add(std::uint64_t{640})
        .Add(std::uint64_t{480})
        .Add(500.0)
        .Add(510.0)
        .Add(320.0)
        .Add(240.0)
        .text();
  }
  static std::string BinaryImages() {
    Bytes bytes;
    bytes.Add(std::uint64_t{2});
    bytes.Add(std::uint32_t{7});
    for (const double v : {0.70710678, 0.0, 0.0, 0.70710678, 1.0, 2.0, 3.0}) {
      bytes.Add(v);
    }
    bytes.Add(std::uint32_t{4}).AddName("b/second.jpg").Add(std::uint64_t{2});
    bytes.Add(10.5).Add(20.5).Add(std::uint64_t{11});
    bytes.Add(1.0).Add(2.0).Add(std::numeric_limits<std::uint64_t>::max());
    bytes.Add(std::uint32_t{2});
    for (const double v : {1.0, 0.0, 0.0, 0.0, 0.0, 0.0, -5.0}) {
      bytes.Add(v);
    }
    return bytes.Add(std::uint32_t{4}).AddName("a first.jpg").Add(std::uint64_t{0}).text();
  }
  static std::string BinaryPoints() {
    Bytes bytes;
    bytes.Add(std::uint64_t{1}).Add(std::uint64_t{11}).Add(1.0).Add(2.0).Add(10.0);
    bytes.Add('\1').Add('\2').Add('\3').Add(0.7).Add(std::uint64_t{2});
    for (const std::uint32_t v : {7U, 0U, 2U, 5U}) {
      bytes.Add(v);
    }
    return bytes.text();
  }

  void ExpectTheModel() const {
    const ColmapModel model = ReadColmapModel(directory_);
    ASSERT_EQ(model.images.size(), 2U);
    EXPECT_EQ(model.images[0].name, "a first.jpg");
    EXPECT_LT((model.images[0].T_W_C.t - Eigen::Vector3d(0, 0, 5)).norm(), 1e-12);
    EXPECT_TRUE(model.images[0].observations.empty());
    const ColmapImage& second = model.images[1];
    EXPECT_EQ(second.name, "b/second.jpg");
    EXPECT_EQ(second.id, 7U);
    // T_C_W turns by 90 degrees about z, then adds (1, 2, 3).
    EXPECT_LT((second.T_W_C.Inverse() * Eigen::Vector3d(1, 0, 0) - Eigen::Vector3d(1, 3, 3)).norm(),
              1e-8);
    ASSERT_EQ(second.observations.size(), 1U);
    EXPECT_EQ(second.observations[0].point, 11U);
    EXPECT_EQ(second.observations[0].pixel, Eigen::Vector2d(10, 20));
    ASSERT_EQ(model.points.count(11), 1U);
    EXPECT_EQ(model.points.at(11).p_W, Eigen::Vector3d(1, 2, 10));
    EXPECT_EQ(model.points.at(11).error_px, 0.7);
    EXPECT_EQ(model.points.at(11).track, 2U);
    const Camera& camera = *model.cameras.at(4);
    EXPECT_EQ(camera.width(), 640);
    EXPECT_EQ(camera.height(), 480);
    const auto pixel = camera.Project({1, 1, 1});
    ASSERT_TRUE(pixel.has_value());
    EXPECT_LT((*pixel - Eigen::Vector2d(819.5, 749.5)).norm(), 1e-9);
  }
};

TEST_F(ColmapTest, ReadsText) {
  WriteText("# CAMERA_ID, MODEL, WIDTH, HEIGHT, PARAMS[]\n4 PINHOLE 640 480 500 510 320 240\n");
  ExpectTheModel();
}

TEST_F(ColmapTest, ReadsBinary) {
  Write("cameras.bin", BinaryCameras());
  Write("images.bin", BinaryImages());
  Write("points3D.bin", BinaryPoints());
  ExpectTheModel();
}

TEST_F(ColmapTest, FindsTheModelBelowAProject) {
  EXPECT_FALSE(IsColmapModel(directory_));
  Write("sparse/0/cameras.txt", "4 PINHOLE 640 480 500 510 320 240\n");
  Write("sparse/0/images.txt", kImages);
  Write("sparse/0/points3D.txt", kPoints);
  EXPECT_TRUE(IsColmapModel(directory_));
  EXPECT_EQ(ReadColmapModel(directory_).directory, directory_ / "sparse/0");
}

// Where a point at (0.3, 0.2, 1) is seen: COLMAP's formulas, written out.
struct Lens {
  const char* text;
  double u, v;
};

TEST_F(ColmapTest, MapsItsCameraModels) {
  const double x = 0.3;
  const double y = 0.2;
  const double r2 = x * x + y * y;
  const double theta = std::atan(std::sqrt(r2));
  const double bend = theta * (1 + 0.1 * theta * theta - 0.05 * std::pow(theta, 4));
  const double fish = bend / std::sqrt(r2);
  const double full = (theta * (1 + 0.1 * std::pow(theta, 2) - 0.05 * std::pow(theta, 4) +
                                0.02 * std::pow(theta, 6) - 0.01 * std::pow(theta, 8))) /
                      std::sqrt(r2);
  const double radial = 1 + 0.1 * r2 - 0.05 * r2 * r2;
  const double tx = 2 * 0.01 * x * y + 0.02 * (r2 + 2 * x * x);
  const double ty = 2 * 0.02 * x * y + 0.01 * (r2 + 2 * y * y);
  for (const Lens& lens : {
           Lens{"SIMPLE_PINHOLE 640 480 500 320 240", 500 * x, 500 * y},
           Lens{"PINHOLE 640 480 500 400 320 240", 500 * x, 400 * y},
           Lens{"SIMPLE_RADIAL 640 480 500 320 240 0.1",
                500 * x * (1 + 0.1 * r2),
                500 * y * (1 + 0.1 * r2)},
           Lens{"RADIAL 640 480 500 320 240 0.1 -0.05", 500 * x * radial, 500 * y * radial},
           Lens{"OPENCV 640 480 500 400 320 240 0.1 -0.05 0.01 0.02",
                500 * (x * radial + tx),
                400 * (y * radial + ty)},
           Lens{"RADIAL_FISHEYE 640 480 500 320 240 0.1 -0.05", 500 * x * fish, 500 * y * fish},
           Lens{"OPENCV_FISHEYE 640 480 500 400 320 240 0.1 -0.05 0.02 -0.01",
                500 * x * full,
                400 * y * full},
       }) {
    WriteText(std::string("4 ") + lens.text + "\n");
    const ColmapModel model = ReadColmapModel(directory_);
    const auto pixel = model.cameras.at(4)->Project({x, y, 1});
    ASSERT_TRUE(pixel.has_value());
    EXPECT_NEAR(pixel->x(), lens.u + 319.5, 1e-9) << lens.text;
    EXPECT_NEAR(pixel->y(), lens.v + 239.5, 1e-9) << lens.text;
  }
}

TEST_F(ColmapTest, NamesFileAndLineOfBadText) {
  const std::string camera = "4 PINHOLE 640 480 500 510 320 240\n";
  EXPECT_THAT(TextError("4 PINHOLE 640 480 500\n"), HasSubstr("cameras.txt:1: expected"));
  EXPECT_THAT(TextError("4 NIKON 640 480 500\n"), HasSubstr("of a model of COLMAP's"));
  EXPECT_THAT(TextError("\n4 FOV 640 480 1 2 3 4 5\n"),
              AllOf(HasSubstr(":2: camera model FOV"), HasSubstr("OPENCV_FISHEYE")));
  EXPECT_THAT(TextError("4 PINHOLE 640 480 -500 510 320 240\n"), HasSubstr("focal lengths -500"));
  EXPECT_THAT(TextError("4 PINHOLE 0 480 500 510 320 240\n"), HasSubstr("0 x 480"));
  EXPECT_THAT(TextError("5 PINHOLE 640 480 500 510 320 240\n"),
              AllOf(HasSubstr("images.txt"), HasSubstr("camera 4, which the model lacks")));
  EXPECT_THAT(TextError(camera, "1 1 0 0 0 0 0 4 a.jpg\n\n"), HasSubstr("images.txt:1: expected"));
  EXPECT_THAT(TextError(camera, "1 1 1 0 0 0 0 0 4 a.jpg\n\n"), HasSubstr("norm 1"));
  EXPECT_THAT(TextError(camera, "1 1 0 0 0 0 0 0 4 a.jpg"), HasSubstr("line of observations"));
  EXPECT_THAT(TextError(camera, "1 1 0 0 0 0 0 0 4 a.jpg\n1 2\n"),
              HasSubstr(":2: expected triples"));
  EXPECT_THAT(TextError(camera, kImages, "11 1 2 nan 1 1 1 0.7\n"), HasSubstr("points3D.txt:1"));
  EXPECT_THAT(TextError(camera, kImages, "11 1 2 3 1 1 1 0.7 5\n"), HasSubstr("TRACK[]"));
}

TEST_F(ColmapTest, SurvivesEveryCutOfABinaryFile) {
  const std::pair<const char*, std::string> files[] = {{"cameras.bin", BinaryCameras()},
                                                       {"images.bin", BinaryImages()},
                                                       {"points3D.bin", BinaryPoints()}};
  for (const auto& [broken, content] : files) {
    for (const auto& [name, whole] : files) {
      Write(name, whole);
    }
    for (std::size_t length = 0; length < content.size(); ++length) {
      Write(broken, content.substr(0, length));
      EXPECT_THAT(MessageOf<InputError>([&] { ReadColmapModel(directory_); }),
                  AllOf(HasSubstr(broken), HasSubstr("cut off")))
          << length;
    }
    Write(broken, content + "x");
    EXPECT_THAT(MessageOf<InputError>([&] { ReadColmapModel(directory_); }),
                AllOf(HasSubstr(broken), HasSubstr("1 bytes too many")));
  }
}

TEST_F(ColmapTest, RefusesBinaryRecordsThatMakeNoSense) {
  Write("cameras.bin", BinaryCameras());
  Write("images.bin", BinaryImages());
  std::string points = BinaryPoints();
  const double nan = std::nan("");
  std::memcpy(&points[16], &nan, sizeof(nan));
  Write("points3D.bin", points);
  EXPECT_THAT(MessageOf<InputError>([&] { ReadColmapModel(directory_); }), HasSubstr("finite"));
  Write("points3D.bin", BinaryPoints());
  std::string cameras = BinaryCameras();
  cameras[12] = 77;
  Write("cameras.bin", cameras);
  EXPECT_THAT(MessageOf<InputError>([&] { ReadColmapModel(directory_); }),
              HasSubstr("camera model 77"));
  // A count that would need more memory than there is.
  Write("cameras.bin", Bytes().Add(std::numeric_limits<std::uint64_t>::max()).text());
  EXPECT_THAT(MessageOf<InputError>([&] { ReadColmapModel(directory_); }), HasSubstr("cut off"));
}

TEST_F(ColmapTest, TrajectoryNeedsStampsInNames) {
  WriteText("4 PINHOLE 640 480 500 510 320 240\n");
  EXPECT_THAT(MessageOf<InputError>([&] { ToTrajectory(ReadColmapModel(directory_)); }),
              HasSubstr("a first.jpg"));
  WriteText("4 PINHOLE 640 480 500 510 320 240\n",
            "1 1 0 0 0 0 0 0 4 a/5.jpg\n\n2 1 0 0 0 0 0 0 4 b/5.jpg\n\n");
  EXPECT_THAT(MessageOf<InputError>([&] { ToTrajectory(ReadColmapModel(directory_)); }),
              HasSubstr("same stamp"));
}

}  // namespace
}  // namespace deja_view
