#include "deja_view/ros/messages/virtual_frame_conversion.hpp"

#include "deja_view/base/check.hpp"
#include "deja_view/camera/kannala_brandt_camera.hpp"
#include "deja_view/camera/pinhole_camera.hpp"

#include <cmath>
#include <functional>
#include <limits>
#include <random>

#include <gmock/gmock.h>
#include <opencv2/core.hpp>
#include <opencv2/imgcodecs.hpp>

namespace deja_view {
namespace {

using ::testing::AllOf;
using ::testing::HasSubstr;

constexpr std::int64_t kStamp = 1403636632538560257;
constexpr int kWidth = 64;
constexpr int kHeight = 48;
const std::string kTopic = "/virtual_cam0/frame";

template <typename T>
cv::Mat MakeRamp(int type, int step) {
  cv::Mat image(kHeight, kWidth, type);
  for (int y = 0; y < kHeight; ++y) {
    for (int x = 0; x < kWidth; ++x) {
      image.at<T>(y, x) = static_cast<T>(step * (x + y));
    }
  }
  return image;
}

VirtualFeatures MakeFeatures() {
  VirtualFeatures result;
  result.descriptor = "brief";
  for (int i = 0; i < 3; ++i) {
    const auto x = static_cast<float>(i);
    result.features.keypoints.push_back({10 * x, 5 * x + 0.25F, 100 - x, 0.1F * x, i});
    Descriptor descriptor;
    descriptor.words = {static_cast<std::uint64_t>(i), 1, ~0ULL, 1ULL << 63U};
    result.features.descriptors.push_back(descriptor);
    result.depth_m.push_back(x);
    result.depth_sigma_m.push_back(0.01F * x);
  }
  return result;
}

VirtualView MakeView() {
  VirtualView view;
  view.stamp_ns = kStamp;
  view.index = 2;
  view.count = 3;
  view.T_C_V = {ExpSo3({0.1, -0.2, 0.05}), {0.02, -0.5, 0.3}};
  view.camera = std::make_shared<PinholeCamera>(
      PinholeParameters{kWidth, kHeight, 60, 61, 31.5, 23.5, -0.1, 0.01, 1e-4, 2e-4});
  view.image = MakeRamp<std::uint8_t>(CV_8UC1, 2);
  view.depth_mm = MakeRamp<std::uint16_t>(CV_16UC1, 500);
  view.certainty = MakeRamp<std::uint8_t>(CV_8UC1, 1);
  view.features = MakeFeatures();
  view.settings_hash = 0xFEDCBA9876543210;
  return view;
}

VirtualFrame MakeMessage() {
  return ToVirtualFrame(MakeView(), "cam0", {ImageFormat::kPng, 90});
}

std::string ErrorOf(const VirtualFrame& message) {
  try {
    FromVirtualFrame(message, kTopic);
  } catch (const InputError& e) {
    return e.what();
  }
  return "no InputError";
}

// That of `edit` on a good message.
std::string ErrorAfter(const std::function<void(VirtualFrame&)>& edit) {
  VirtualFrame message = MakeMessage();
  edit(message);
  return ErrorOf(message);
}

void ExpectSameFeatures(const VirtualFeatures& a, const VirtualFeatures& b) {
  EXPECT_EQ(a.descriptor, b.descriptor);
  EXPECT_EQ(a.features.descriptors, b.features.descriptors);
  EXPECT_EQ(a.depth_m, b.depth_m);
  EXPECT_EQ(a.depth_sigma_m, b.depth_sigma_m);
  ASSERT_EQ(a.features.keypoints.size(), b.features.keypoints.size());
  for (std::size_t i = 0; i < a.features.keypoints.size(); ++i) {
    const Keypoint& ka = a.features.keypoints[i];
    const Keypoint& kb = b.features.keypoints[i];
    EXPECT_EQ(ka.x, kb.x);
    EXPECT_EQ(ka.y, kb.y);
    EXPECT_EQ(ka.response, kb.response);
    EXPECT_EQ(ka.angle, kb.angle);
    EXPECT_EQ(ka.octave, kb.octave);
  }
}

TEST(VirtualFrameConversionTest, RoundTripLosesNothing) {
  const VirtualView view = MakeView();
  const VirtualFrame message = MakeMessage();
  EXPECT_EQ(message.header.frame_id, "cam0");
  const VirtualView back = FromVirtualFrame(message, kTopic);
  EXPECT_EQ(back.stamp_ns, kStamp);
  EXPECT_EQ(back.index, 2);
  EXPECT_EQ(back.count, 3);
  EXPECT_EQ(back.settings_hash, view.settings_hash);
  EXPECT_LT((back.T_C_V.t - view.T_C_V.t).norm(), 1e-15);
  EXPECT_LT(back.T_C_V.q.angularDistance(view.T_C_V.q), 1e-12);
  EXPECT_EQ(back.camera->ModelType(), "PINHOLE");
  EXPECT_EQ(*back.camera->Project({0.1, 0.2, 1}), *view.camera->Project({0.1, 0.2, 1}));
  EXPECT_EQ(cv::norm(back.image, view.image, cv::NORM_INF), 0);
  EXPECT_EQ(cv::norm(back.depth_mm, view.depth_mm, cv::NORM_INF), 0);
  EXPECT_EQ(cv::norm(back.certainty, view.certainty, cv::NORM_INF), 0);
  ExpectSameFeatures(back.features, view.features);
}

TEST(VirtualFrameConversionTest, JpegIsSmallAndNear) {
  const VirtualView view = MakeView();
  const VirtualFrame message = ToVirtualFrame(view, "cam0");
  EXPECT_EQ(message.image_format, "jpeg");
  const cv::Mat image = FromVirtualFrame(message, kTopic).image;
  EXPECT_LE(cv::norm(image, view.image, cv::NORM_INF), 8);
  EXPECT_EQ(ToVirtualFrame(view, "cam0").image, message.image);
}

TEST(VirtualFrameConversionTest, ImageOrFeaturesAlone) {
  VirtualView view = MakeView();
  view.depth_mm.release();
  view.certainty.release();
  view.features = {};
  const VirtualView image = FromVirtualFrame(ToVirtualFrame(view, "cam0"), kTopic);
  EXPECT_TRUE(image.features.descriptor.empty());
  EXPECT_TRUE(image.depth_mm.empty());
  view.features = MakeFeatures();
  view.image.release();
  const VirtualView features = FromVirtualFrame(ToVirtualFrame(view, "cam0"), kTopic);
  EXPECT_TRUE(features.image.empty());
  EXPECT_EQ(features.features.features.keypoints.size(), 3U);
  view.features = {};
  EXPECT_THROW(ToVirtualFrame(view, "cam0"), CheckError);
  view.features = MakeFeatures();
  view.features.depth_m.pop_back();
  EXPECT_THROW(ToVirtualFrame(view, "cam0"), CheckError);
}

TEST(VirtualFrameConversionTest, DecodesNoImagesWhereFeaturesSuffice) {
  VirtualFrame message = MakeMessage();
  message.image.resize(message.image.size() / 2);  // can't be decoded
  const VirtualView brief = FromVirtualFrame(message, kTopic, "brief");
  EXPECT_TRUE(brief.image.empty());
  EXPECT_TRUE(brief.depth_mm.empty());
  ExpectSameFeatures(brief.features, MakeView().features);
  EXPECT_THROW(FromVirtualFrame(message, kTopic, "orb"), InputError);
  EXPECT_THROW(FromVirtualFrame(message, kTopic), InputError);
}

TEST(VirtualFrameConversionTest, KeepsAFisheye) {
  VirtualView view = MakeView();
  view.camera = std::make_shared<KannalaBrandtCamera>(
      KannalaBrandtParameters{kWidth, kHeight, 0.01, 0.02, 0.03, 0.04, 30, 31, 32, 24});
  const VirtualView back = FromVirtualFrame(ToVirtualFrame(view, "cam0"), kTopic);
  EXPECT_EQ(*back.camera->Project({0.1, 0.2, 1}), *view.camera->Project({0.1, 0.2, 1}));
}

TEST(VirtualFrameConversionTest, NamesTheBadField) {
  const auto names = [](const char* a, const char* b) {
    return AllOf(HasSubstr(kTopic), HasSubstr(a), HasSubstr(b));
  };
  EXPECT_THAT(ErrorAfter([](auto& m) { m.view_index = 3; }), names("view_index 3", "count 3"));
  EXPECT_THAT(ErrorAfter([](auto& m) { m.view_index = -1; }), names("view_index -1", "0 or more"));
  EXPECT_THAT(ErrorAfter([](auto& m) { m.T_C_V.orientation.w = NAN; }), names("pose", "nan"));
  EXPECT_THAT(ErrorAfter([](auto& m) { m.camera_model = "X"; }), names("camera model", "PINHOLE"));
  EXPECT_THAT(ErrorAfter([](auto& m) { m.projection.clear(); }), names("projection", "fx"));
  EXPECT_THAT(ErrorAfter([](auto& m) { m.width = 4000000000U; }), names("camera of", "32768"));
  EXPECT_THAT(ErrorAfter([](auto& m) { m.image_format = "gif"; }), names("image_format", "jpeg"));
  EXPECT_THAT(ErrorAfter([](auto& m) { m.image.resize(30); }), names("image", "decoded"));
  EXPECT_THAT(ErrorAfter([](auto& m) { m.width = 65; }), names("image", "expected PNG or JPEG"));
  EXPECT_THAT(ErrorAfter([](auto& m) { m.depth_png = m.certainty_png; }),
              names("depth_png", "16 bits"));
  EXPECT_THAT(ErrorAfter([](auto& m) { m.certainty_png = m.depth_png; }),
              names("certainty_png", "8 bits"));
  EXPECT_THAT(ErrorAfter([](auto& m) { m.descriptor = "sift"; }), names("descriptor", "brief"));
  EXPECT_THAT(ErrorAfter([](auto& m) { m.descriptor.clear(); }), names("descriptor is", "3"));
  EXPECT_THAT(ErrorAfter([](auto& m) { m.v.pop_back(); }), names("v of length 2", "3 keypoints"));
  EXPECT_THAT(ErrorAfter([](auto& m) { m.descriptors.pop_back(); }), names("descriptors", "96"));
  EXPECT_THAT(ErrorAfter([](auto& m) { m.u[1] = 64; }), names("u[1] is 64", "64 px"));
  EXPECT_THAT(ErrorAfter([](auto& m) { m.v[2] = NAN; }), names("v[2] is nan", "48 px"));
  EXPECT_THAT(ErrorAfter([](auto& m) { m.response[0] = INFINITY; }), names("response[0]", "inf"));
  EXPECT_THAT(ErrorAfter([](auto& m) { m.angle[0] = NAN; }), names("angle[0]", "finite"));
  EXPECT_THAT(ErrorAfter([](auto& m) { m.depth[2] = -1; }), names("depth[2] is -1", "0 or more"));
  EXPECT_THAT(ErrorAfter([](auto& m) { m.depth_sigma[2] = INFINITY; }),
              names("depth_sigma[2]", "finite"));
  EXPECT_THAT(ErrorAfter([](auto& m) {
                m.image.clear();
                m.descriptor.clear();
              }),
              names("neither image nor features", "expected"));
}

TEST(VirtualFrameConversionTest, KnowsTheSizeOfAnImageBeforeDecodingIt) {
  // Black pixels take next to no bytes.
  for (const char* extension : {".png", ".jpg"}) {
    std::vector<std::uint8_t> large;
    cv::imencode(extension, cv::Mat::zeros(500, 3000, CV_8UC1), large);
    EXPECT_THAT(ErrorAfter([&](auto& m) { m.image = large; }), HasSubstr("3000 x 500"));
  }
}

// Any value of a field, rarely a sensible one.
class Mutator {
 public:
  explicit Mutator(unsigned seed) : random_(seed) {}

  void Mutate(VirtualFrame* m) {
    switch (random_() % 14) {
      case 0:
        m->view_index = static_cast<std::int32_t>(random_());
        break;
      case 1:
        m->view_count = static_cast<std::int32_t>(random_() % 5);
        break;
      case 2:
        m->T_C_V.position.x = Number();
        break;
      case 3:
        m->T_C_V.orientation.z = Number();
        break;
      case 4:
        m->width = static_cast<std::uint32_t>(random_() % 3 == 0 ? random_() : random_() % 100);
        break;
      case 5:
        m->camera_model = random_() % 2 == 0 ? "MEI" : "KANNALA_BRANDT";
        break;
      case 6:
        MutateList(&m->distortion);
        break;
      case 7:
        MutateList(&m->projection);
        break;
      case 8:
        MutateBytes(&m->image);
        break;
      case 9:
        MutateBytes(&m->depth_png);
        break;
      case 10:
        MutateBytes(&m->certainty_png);
        break;
      case 11:
        MutateBytes(&m->descriptors);
        break;
      case 12:
        MutateList(random_() % 2 == 0 ? &m->u : &m->response);
        break;
      default:
        MutateList(random_() % 2 == 0 ? &m->depth : &m->depth_sigma);
        break;
    }
  }

 private:
  double Number() {
    constexpr double kNumbers[] = {0, -1, 1e-300, 1e300, 3, 0.5, NAN, INFINITY, -INFINITY, 70};
    return kNumbers[random_() % 10];
  }
  template <typename T>
  void MutateList(std::vector<T>* list) {
    if (random_() % 3 == 0) {
      list->resize(random_() % 6);
    }
    if (!list->empty()) {
      (*list)[random_() % list->size()] = static_cast<T>(Number());
    }
  }
  void MutateBytes(std::vector<std::uint8_t>* bytes) {
    if (random_() % 4 == 0) {
      bytes->resize(random_() % (bytes->size() + 1));
    }
    for (std::size_t i = 0; i < 3 && !bytes->empty(); ++i) {
      (*bytes)[random_() % bytes->size()] = static_cast<std::uint8_t>(random_());
    }
  }
  std::mt19937 random_;
};

void ExpectWellFormed(const VirtualView& view) {
  ASSERT_NE(view.camera, nullptr);
  const cv::Size size(view.camera->width(), view.camera->height());
  EXPECT_TRUE(view.image.empty() || view.image.size() == size);
  EXPECT_TRUE(view.depth_mm.empty() || view.depth_mm.size() == size);
  EXPECT_TRUE(view.T_C_V.IsFinite());
  EXPECT_TRUE(view.camera->Unproject({5, 5}).allFinite());
  const std::size_t count = view.features.features.keypoints.size();
  EXPECT_EQ(view.features.features.descriptors.size(), count);
  EXPECT_EQ(view.features.depth_m.size(), count);
  EXPECT_EQ(view.features.depth_sigma_m.size(), count);
  for (const float depth : view.features.depth_m) {
    EXPECT_TRUE(depth >= 0 && std::isfinite(depth));
  }
}

TEST(VirtualFrameConversionTest, SurvivesRandomMessages) {
  const VirtualFrame good = MakeMessage();
  int accepted = 0;
  int refused = 0;
  for (unsigned seed = 0; seed < 3000; ++seed) {
    Mutator mutator(seed);
    VirtualFrame message = good;
    for (unsigned i = 0; i <= seed % 3; ++i) {
      mutator.Mutate(&message);
    }
    try {
      ExpectWellFormed(FromVirtualFrame(message, kTopic));
      ++accepted;
    } catch (const InputError& e) {
      EXPECT_THAT(e.what(), ::testing::StartsWith(kTopic + ":"));
      ++refused;
    }
  }
  EXPECT_GT(accepted, 100);
  EXPECT_GT(refused, 1000);
}

}  // namespace
}  // namespace deja_view
