#include "deja_view/camera/camera_parameters.hpp"

#include "deja_view/base/check.hpp"
#include "deja_view/camera/kannala_brandt_camera.hpp"
#include "deja_view/camera/mei_camera.hpp"
#include "deja_view/camera/pinhole_camera.hpp"

#include <functional>
#include <limits>

#include <gmock/gmock.h>

namespace deja_view {
namespace {

using ::testing::AllOf;
using ::testing::ElementsAreArray;
using ::testing::HasSubstr;

std::string ErrorOf(const CameraParameters& parameters) {
  try {
    MakeCamera(parameters, "/topic");
  } catch (const InputError& e) {
    return e.what();
  }
  return "no InputError";
}

const CameraParameters kPinhole = {
    "PINHOLE", 752, 480, {-0.28, 0.07, 1e-4, 2e-5}, {458.6, 457.2, 367.2, 248.3}};
const CameraParameters kFisheye = {
    "KANNALA_BRANDT", 640, 480, {-0.01, 0.02, -0.003, 0.001}, {380, 381, 320, 240}};
const CameraParameters kMei = {
    "MEI", 800, 600, {-0.1, 0.05, 1e-4, 2e-4}, {0.9, 700, 701, 400, 300}};

TEST(CameraParametersTest, RoundTripOfAllModels) {
  for (const CameraParameters& parameters : {kPinhole, kFisheye, kMei}) {
    const auto camera = MakeCamera(parameters, "camera");
    EXPECT_EQ(camera->ModelType(), parameters.model);
    const CameraParameters back = DescribeCamera(*camera);
    EXPECT_EQ(back.model, parameters.model);
    EXPECT_EQ(back.width, parameters.width);
    EXPECT_EQ(back.height, parameters.height);
    EXPECT_EQ(back.distortion, parameters.distortion);
    EXPECT_EQ(back.projection, parameters.projection);
  }
}

TEST(CameraParametersTest, NumbersStandInTheirOrder) {
  const auto pinhole = MakeCamera(kPinhole, "camera");
  const PinholeParameters& p = dynamic_cast<const PinholeCamera&>(*pinhole).parameters();
  EXPECT_THAT((std::vector<double>{p.k1, p.k2, p.p1, p.p2}), ElementsAreArray(kPinhole.distortion));
  EXPECT_THAT((std::vector<double>{p.fx, p.fy, p.cx, p.cy}), ElementsAreArray(kPinhole.projection));
  const auto fisheye = MakeCamera(kFisheye, "camera");
  const KannalaBrandtParameters& k =
      dynamic_cast<const KannalaBrandtCamera&>(*fisheye).parameters();
  EXPECT_THAT((std::vector<double>{k.k2, k.k3, k.k4, k.k5}), ElementsAreArray(kFisheye.distortion));
  EXPECT_THAT((std::vector<double>{k.mu, k.mv, k.u0, k.v0}), ElementsAreArray(kFisheye.projection));
  const auto mei = MakeCamera(kMei, "camera");
  const MeiParameters& m = dynamic_cast<const MeiCamera&>(*mei).parameters();
  EXPECT_THAT((std::vector<double>{m.k1, m.k2, m.p1, m.p2}), ElementsAreArray(kMei.distortion));
  EXPECT_THAT((std::vector<double>{m.xi, m.gamma1, m.gamma2, m.u0, m.v0}),
              ElementsAreArray(kMei.projection));
}

TEST(CameraParametersTest, NamesWhatIsWrong) {
  CameraParameters bad = kPinhole;
  bad.model = "FISHEYE";
  EXPECT_THAT(ErrorOf(bad), AllOf(HasSubstr("/topic"), HasSubstr("FISHEYE"), HasSubstr("MEI")));
  bad = kPinhole;
  bad.width = 0;
  EXPECT_THAT(ErrorOf(bad), HasSubstr("0 x 480"));
  bad = kFisheye;
  bad.height = 40000;
  EXPECT_THAT(ErrorOf(bad), HasSubstr("32768"));
  bad = kFisheye;
  bad.distortion.push_back(1);
  EXPECT_THAT(ErrorOf(bad), AllOf(HasSubstr("distortion"), HasSubstr("k2, k3, k4, k5")));
  bad = kMei;
  bad.projection[2] = std::numeric_limits<double>::quiet_NaN();
  EXPECT_THAT(ErrorOf(bad), AllOf(HasSubstr("projection"), HasSubstr("finite")));
  bad = kMei;
  bad.projection[0] = -1;
  EXPECT_THAT(ErrorOf(bad), HasSubstr("xi -1"));
  bad = kPinhole;
  bad.projection[1] = 0;
  EXPECT_THAT(ErrorOf(bad), HasSubstr("focal lengths 458.6 and 0"));
}

}  // namespace
}  // namespace deja_view
