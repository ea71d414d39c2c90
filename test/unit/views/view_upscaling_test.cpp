#include "deja_view/views/view_upscaling.hpp"

#include "deja_view/base/check.hpp"
#include "deja_view/camera/pinhole_camera.hpp"

#include <fstream>

#include "room_renderer.hpp"
#include <gmock/gmock.h>
#include <opencv2/imgproc.hpp>

namespace deja_view {
namespace {

using ::testing::HasSubstr;

const PinholeCamera kCamera({320, 240, 200, 200, 159.5, 119.5, -0.1, 0.01, 0, 0});
const Rigid3 kPose{ExpSo3({0.1, 0.3, 0}), {0.5, 0.2, -0.3}};

// Has no texture left of the camera's axis, and counts the pixels that it is asked for.
class CountingRenderer final : public RoomRenderer {
 public:
  RenderedView Render(const Camera& camera,
                      const Rigid3& T_N_C,
                      const ViewRenderOptions& options) const override {
    pixels += camera.width() * camera.height();
    RenderedView view = RoomRenderer::Render(camera, T_N_C, options);
    for (int y = 0; y < camera.height(); ++y) {
      for (int x = 0; x < camera.width(); ++x) {
        if (camera.Unproject({x, y}).x() < 0) {
          view.image.at<std::uint8_t>(y, x) = 128;
        }
      }
    }
    return view;
  }
  mutable int pixels = 0;
};

double Error(const cv::Mat& a, const cv::Mat& b) {
  cv::Mat difference;
  cv::absdiff(a, b, difference);
  return cv::mean(difference)[0];
}

RenderedView RenderWith(Upscaling method, int* pixels) {
  UpscalingOptions options;
  options.method = method;
  const CountingRenderer room;
  RenderedView view = ViewUpscaler(options).Render(room, kCamera, kPose, {1, 0, 1});
  *pixels = room.pixels;
  return view;
}

TEST(ViewUpscalingTest, DirectIsTheRenderersOwn) {
  int pixels = 0;
  const RenderedView view = RenderWith(Upscaling::kDirect, &pixels);
  EXPECT_EQ(pixels, 320 * 240);
  const RenderedView truth = CountingRenderer().Render(kCamera, kPose, {});
  EXPECT_EQ(cv::norm(view.image, truth.image, cv::NORM_INF), 0);
}

TEST(ViewUpscalingTest, BicubicRendersAQuarterOfThePixels) {
  int pixels = 0;
  const RenderedView view = RenderWith(Upscaling::kBicubic, &pixels);
  EXPECT_EQ(pixels, 160 * 120);
  const RenderedView truth = CountingRenderer().Render(kCamera, kPose, {});
  ASSERT_EQ(view.image.size(), truth.image.size());
  EXPECT_LT(Error(view.image, truth.image), 6);
  EXPECT_LT(cv::mean(cv::abs(view.depth - truth.depth))[0], 0.02);
}

TEST(ViewUpscalingTest, KeepsPixelsWhereTheCameraHasThem) {
  // What lies at (x, y) of the whole image lies where Camera::Scaled(0.5) projects it.
  const auto half_camera = kCamera.Scaled(0.5);
  cv::Mat half(120, 160, CV_32FC1);
  for (int y = 0; y < 120; ++y) {
    for (int x = 0; x < 160; ++x) {
      const Eigen::Vector2d pixel = *kCamera.Project(half_camera->Unproject({x, y}));
      half.at<float>(y, x) = static_cast<float>(3 * pixel.x() + pixel.y());
    }
  }
  const cv::Mat whole = ResizeFromHalf(half, {320, 240}, cv::INTER_LINEAR);
  for (int y = 10; y < 230; y += 7) {
    for (int x = 10; x < 310; x += 7) {
      EXPECT_NEAR(whole.at<float>(y, x), 3 * x + y, 0.05);
    }
  }
}

TEST(ViewUpscalingTest, PatchesAreExactAboutCorners) {
  int pixels = 0;
  const RenderedView view = RenderWith(Upscaling::kPatches, &pixels);
  EXPECT_LT(pixels, 160 * 120 + 320 * 240);
  EXPECT_GT(pixels, 160 * 120);
  const RenderedView truth = CountingRenderer().Render(kCamera, kPose, {});
  const RenderedView bicubic = RenderWith(Upscaling::kBicubic, &pixels);
  EXPECT_LT(Error(view.image, truth.image), 0.6 * Error(bicubic.image, truth.image));
}

TEST(ViewUpscalingTest, AFlatImageHasNoPatches) {
  class Grey final : public ViewRenderer {
   public:
    RenderedView Render(const Camera& camera,
                        const Rigid3& /*T_N_C*/,
                        const ViewRenderOptions& /*options*/) const override {
      EXPECT_EQ(camera.width(), 160);
      const cv::Size size(camera.width(), camera.height());
      const cv::Mat ones = cv::Mat::ones(size, CV_32FC1);
      return {cv::Mat(size, CV_8UC1, cv::Scalar(77)), ones, ones, ones};
    }
  };
  UpscalingOptions options;
  options.method = Upscaling::kPatches;
  const RenderedView view = ViewUpscaler(options).Render(Grey(), kCamera, kPose, {});
  EXPECT_EQ(cv::norm(view.image, cv::Mat(240, 320, CV_8UC1, cv::Scalar(77)), cv::NORM_INF), 0);
}

TEST(ViewUpscalingTest, NamesANetworkThatCannotBeRead) {
  UpscalingOptions options;
  options.method = Upscaling::kFsrcnn;
  EXPECT_TRUE(options.Validate().empty());
  options.network.clear();
  EXPECT_THAT(options.Validate(), ::testing::ElementsAre(HasSubstr("network is empty")));
  const auto error_of = [&options](const std::string& path) -> std::string {
    options.network = path;
    try {
      ViewUpscaler upscaler(options);
    } catch (const InputError& e) {
      return e.what();
    }
    return "no InputError";
  };
  EXPECT_THAT(error_of("/nowhere/FSRCNN_x2.pb"), HasSubstr("/nowhere/FSRCNN_x2.pb"));
  const std::string path = ::testing::TempDir() + "deja_view_no_network.onnx";
  std::ofstream(path) << "not a network";
  EXPECT_THAT(error_of(path), HasSubstr(path));
}

TEST(ViewUpscalingTest, LooksForANetworkInTheGivenDirectories) {
  const std::filesystem::path directory = ::testing::TempDir();
  const std::string name = "deja_view_some_network.onnx";
  std::ofstream(directory / name) << "network";
  EXPECT_EQ(FindNetwork(directory / name, {}), directory / name);
  EXPECT_EQ(FindNetwork(name, {"/nowhere", directory}), directory / name);
  EXPECT_EQ(FindNetwork(name, {"/nowhere"}), name);
  std::filesystem::remove(directory / name);
}

}  // namespace
}  // namespace deja_view
