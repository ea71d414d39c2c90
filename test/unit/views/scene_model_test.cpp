#include "deja_view/views/scene_model.hpp"

#include "deja_view/camera/pinhole_camera.hpp"

#include "test_cameras.hpp"
#include <gtest/gtest.h>
#include <opencv2/core.hpp>

namespace deja_view {
namespace {

const PinholeCamera kTinyCamera = PinholeOf(4, 3, 3, 1.5, 1);

// Shows the x of the camera and the range of the first point, both in N.
class Probe final : public SceneModel {
 public:
  Similarity3 FindFrame(const std::optional<Similarity3>& /*told*/) const override { return {}; }
  std::shared_ptr<const ViewRenderer> RendererFor(
      const ViewSource& source, const std::vector<RangeSample>& points) const override {
    return std::make_shared<Renderer>(source.T_N_C.t.x(), points.front().range_m);
  }
  std::string Describe() const override { return ""; }

 private:
  class Renderer final : public ViewRenderer {
   public:
    Renderer(double x, double range) : x_(x), range_(range) {}
    RenderedView Render(const Camera& /*camera*/,
                        const Rigid3& T_N_C,
                        const ViewRenderOptions& /*options*/) const override {
      RenderedView view;
      view.depth = (cv::Mat_<float>(1, 3) << x_, T_N_C.t.x(), range_);
      view.depth_variance = cv::Mat::zeros(1, 3, CV_32FC1);
      return view;
    }

   private:
    double x_;
    double range_;
  };
};

TEST(SceneModelTest, SourcesPointsAndViewsAreInTheWorld) {
  const Similarity3 W_N{2.0, {Eigen::Quaterniond::Identity(), {10, 0, 0}}};
  const auto renderers = RenderersInWorld(std::make_shared<Probe>(), W_N);
  const ViewSource source{1, cv::Mat(), {Eigen::Quaterniond::Identity(), {14, 0, 0}}};
  const auto renderer = renderers(source, {{{0, 0}, 6}});
  const Rigid3 T_W_V{Eigen::Quaterniond::Identity(), {16, 0, 0}};
  const cv::Mat depth = renderer->Render(kTinyCamera, T_W_V, {}).depth;
  // The depths that the renderer gives are in N, too: 2, 3 and 3 become twice as many metres.
  EXPECT_EQ(depth.at<float>(0), 4);
  EXPECT_EQ(depth.at<float>(1), 6);
  EXPECT_EQ(depth.at<float>(2), 6);
}

TEST(SceneModelTest, ModelsOfLittleKnowledgeAreNeutral) {
  const Probe model;
  EXPECT_FALSE(model.NeedsPoints());
  EXPECT_FALSE(model.cells().IsCut());
  EXPECT_EQ(model.ExposureAt(5).gain, 1);
  EXPECT_EQ(model.ExposureAt(5).bias, 0);
}

}  // namespace
}  // namespace deja_view
