#include "deja_view/base/check.hpp"
#include "deja_view/camera/camera_parameters.hpp"
#include "deja_view/camera/kannala_brandt_camera.hpp"
#include "deja_view/camera/mei_camera.hpp"
#include "deja_view/camera/pinhole_camera.hpp"
#include "deja_view/io/colmap.hpp"

#include <memory>

#include "temporary_directory.hpp"
#include <gmock/gmock.h>

namespace deja_view {
namespace {

class ColmapWriterTest : public TemporaryDirectoryTest {
 protected:
  static ColmapModel Model() {
    ColmapModel model;
    model.cameras[1] = std::make_shared<PinholeCamera>(
        PinholeParameters{640, 480, 420.25, 418.5, 322, 243, -0.12, 0.04, 0.0005, -0.001});
    model.cameras[3] = std::make_shared<KannalaBrandtCamera>(
        KannalaBrandtParameters{640, 480, -0.01, 0.02, -0.01, 0.002, 300, 302, 321, 239});
    model.images = {{1, 1, "a.png", {ExpSo3({0.1, 0.2, 0.3}), {1, 2, 3}}, {{{10.25, 20}, 7}}},
                    {2, 3, "b/c d.png", {ExpSo3({-1, 0.2, 2}), {4, 5, 6}}, {{{30, 40.5}, 7}}}};
    model.points[7] = {{0.1, -0.2, 0.3}, 0.5, 2};
    return model;
  }
};

TEST_F(ColmapWriterTest, WritesWhatTheReaderReads) {
  const ColmapModel model = Model();
  WriteColmapModel(model, directory_ / "sparse");
  const ColmapModel read = ReadColmapModel(directory_);
  ASSERT_EQ(read.images.size(), 2U);
  for (std::size_t i = 0; i < 2; ++i) {
    EXPECT_EQ(read.images[i].name, model.images[i].name);
    EXPECT_EQ(read.images[i].camera, model.images[i].camera);
    EXPECT_LT((read.images[i].T_W_C.t - model.images[i].T_W_C.t).norm(), 1e-9);
    EXPECT_LT(read.images[i].T_W_C.q.angularDistance(model.images[i].T_W_C.q), 1e-7);
    ASSERT_EQ(read.images[i].observations.size(), 1U);
    EXPECT_LT((read.images[i].observations[0].pixel - model.images[i].observations[0].pixel).norm(),
              1e-9);
    EXPECT_EQ(read.images[i].observations[0].point, 7U);
  }
  for (const auto& [id, camera] : model.cameras) {
    const CameraParameters a = DescribeCamera(*camera);
    const CameraParameters b = DescribeCamera(*read.cameras.at(id));
    EXPECT_EQ(a.model, b.model);
    EXPECT_EQ(a.projection, b.projection);
    EXPECT_EQ(a.distortion, b.distortion);
  }
  EXPECT_EQ(read.points.at(7).p_W, model.points.at(7).p_W);
  EXPECT_EQ(read.points.at(7).track, 2U);
}

TEST_F(ColmapWriterTest, RefusesACameraThatColmapDoesNotKnow) {
  ColmapModel model = Model();
  model.cameras[1] = std::make_shared<MeiCamera>(
      MeiParameters{640, 480, 0.9, -0.2, 0.05, 0.001, -0.001, 600, 602, 321, 239});
  EXPECT_THROW(WriteColmapModel(model, directory_), InputError);
}

}  // namespace
}  // namespace deja_view
