#include "stored_view.hpp"

#include "deja_view/base/check.hpp"
#include "deja_view/views/virtual_features.hpp"

#include <algorithm>
#include <cmath>

namespace deja_view {
namespace {

/// A feature before it is packed.
struct ViewFeature {
  Keypoint keypoint;
  Descriptor descriptor;
  float depth_m = 0;
  float sigma_m = 0;
};

std::uint16_t Pack(float value, float scale) {
  return static_cast<std::uint16_t>(
      std::clamp<long>(std::lround(value * scale), 0L, std::int64_t{65535}));
}

bool FitsImage(const cv::Mat& map, int type, const Camera& camera) {
  return map.empty() ||
         (map.type() == type && map.cols == camera.width() && map.rows == camera.height());
}

std::vector<ViewFeature> FromMessage(const VirtualFeatures& offline) {
  std::vector<ViewFeature> features(offline.features.keypoints.size());
  for (std::size_t i = 0; i < features.size(); ++i) {
    features[i] = {offline.features.keypoints[i],
                   offline.features.descriptors[i],
                   offline.depth_m[i],
                   offline.depth_sigma_m[i]};
  }
  return features;
}

/// Those of `features` that were described as `vertical` asks for, to within a step.
std::vector<ViewFeature> TurnedAs(const VerticalField& vertical,
                                  std::vector<ViewFeature> features) {
  const auto is_turned_otherwise = [&](const ViewFeature& f) {
    const float difference = vertical.Angle(f.keypoint.x, f.keypoint.y) - f.keypoint.angle;
    return !(std::cos(difference) > std::cos(VerticalField::kStepAngle));
  };
  if (!vertical.empty()) {
    features.erase(std::remove_if(features.begin(), features.end(), is_turned_otherwise),
                   features.end());
  }
  return features;
}

/// A message's own, unless most were turned otherwise and there is an image to extract from.
std::vector<ViewFeature> FeaturesOf(const VirtualView& view,
                                    const FeatureExtractor& extractor,
                                    const VerticalField& vertical,
                                    const VirtualViewOptions& options) {
  if (view.features.descriptor == extractor.DescriptorName() &&
      (options.use_offline || view.image.empty())) {
    std::vector<ViewFeature> own = TurnedAs(vertical, FromMessage(view.features));
    if (view.image.empty() || 2 * own.size() >= view.features.features.keypoints.size()) {
      return own;
    }
  }
  return FromMessage(ExtractVirtualFeatures(view, extractor, vertical, options.min_certainty));
}

bool IsSound(const ViewFeature& f, const Camera& camera) {
  return std::isfinite(f.keypoint.x) && std::isfinite(f.keypoint.y) &&
         camera.IsInImage({f.keypoint.x, f.keypoint.y}) && std::isfinite(f.keypoint.response) &&
         std::isfinite(f.depth_m) && f.depth_m >= 0 && std::isfinite(f.sigma_m) && f.sigma_m >= 0;
}

}  // namespace

void CheckView(const VirtualView& view, const std::string& descriptor_name) {
  const auto fail = [&](const std::string& what) {
    ThrowInputError("virtual view {} of stamp {} ns: {}", view.index, view.stamp_ns, what);
  };
  if (view.camera == nullptr) {
    fail("it has no camera");
  }
  constexpr int kMaxIndex = 1'000'000;
  constexpr int kMaxPixels = 4095;
  if (view.index < 0 || view.index > kMaxIndex) {
    fail("expected an index from 0 to 1000000");
  }
  if (view.camera->width() > kMaxPixels || view.camera->height() > kMaxPixels) {
    fail(fmt::format("the camera is {}x{}, expected at most 4095 pixels a side",
                     view.camera->width(),
                     view.camera->height()));
  }
  if (!view.T_C_V.IsFinite() || std::abs(view.T_C_V.q.norm() - 1.0) > 1e-3) {
    fail("T_C_V is not a finite rigid transform");
  }
  if (!FitsImage(view.image, CV_8UC1, *view.camera)) {
    fail("the image is not of 8 bits grey in the camera's size");
  }
  if (!FitsImage(view.depth_mm, CV_16UC1, *view.camera)) {
    fail("the depth is not of 16 bits in the camera's size");
  }
  if (!FitsImage(view.certainty, CV_8UC1, *view.camera)) {
    fail("the certainty is not of 8 bits in the camera's size");
  }
  const VirtualFeatures& f = view.features;
  const std::size_t count = f.features.keypoints.size();
  if (f.features.descriptors.size() != count || f.depth_m.size() != count ||
      f.depth_sigma_m.size() != count) {
    fail("its lists of features differ in length");
  }
  if (view.image.empty() && f.descriptor != descriptor_name) {
    fail(fmt::format("it has no image, and features of kind '{}': expected '{}'",
                     f.descriptor,
                     descriptor_name));
  }
}

StoredView MakeStoredView(const VirtualView& view,
                          const FeatureExtractor& extractor,
                          const VerticalField& vertical,
                          const VirtualViewOptions& options) {
  std::vector<ViewFeature> features = FeaturesOf(view, extractor, vertical, options);
  features.erase(std::remove_if(features.begin(),
                                features.end(),
                                [&](const ViewFeature& f) { return !IsSound(f, *view.camera); }),
                 features.end());
  const auto most = static_cast<std::size_t>(options.max_features);
  if (features.size() > most) {
    std::stable_sort(features.begin(), features.end(), [](const auto& a, const auto& b) {
      return a.keypoint.response > b.keypoint.response;
    });
    features.resize(most);
  }
  StoredView stored;
  stored.index = view.index;
  stored.T_C_V = view.T_C_V;
  stored.camera = view.camera;
  stored.keypoints.reserve(features.size());
  stored.descriptors.reserve(features.size());
  for (const ViewFeature& f : features) {
    const float sigma =
        f.sigma_m > 0 ? f.sigma_m : static_cast<float>(options.unknown_depth_sigma) * f.depth_m;
    constexpr float kMostMetres = 65.0F;
    const bool has_depth = f.depth_m > 0 && f.depth_m < kMostMetres;
    stored.keypoints.push_back(
        {Pack(f.keypoint.x, PackedKeypoint::kPerPixel),
         Pack(f.keypoint.y, PackedKeypoint::kPerPixel),
         has_depth ? Pack(f.depth_m, PackedKeypoint::kPerMetre) : std::uint16_t{0},
         has_depth ? Pack(sigma, PackedKeypoint::kPerMetre) : std::uint16_t{0}});
    stored.descriptors.push_back(f.descriptor);
  }
  return stored;
}

RigCamera ToRigCamera(const StoredView& view,
                      const Rigid3& T_B_C,
                      const VirtualViewOptions& options) {
  RigCamera rig;
  rig.camera = view.camera;
  rig.number = view.index;
  KeyframeFeatures& f = rig.features;
  f.T_B_C = T_B_C * view.T_C_V;
  f.descriptors = view.descriptors;
  f.keypoints.reserve(view.keypoints.size());
  for (std::size_t i = 0; i < view.keypoints.size(); ++i) {
    const PackedKeypoint& k = view.keypoints[i];
    const Eigen::Vector2f pixel(static_cast<float>(k.u) / PackedKeypoint::kPerPixel,
                                static_cast<float>(k.v) / PackedKeypoint::kPerPixel);
    f.keypoints.push_back(pixel);
    if (k.depth == 0 || k.sigma > options.max_depth_sigma * k.depth) {
      continue;
    }
    const double depth = static_cast<double>(k.depth) / PackedKeypoint::kPerMetre;
    const Eigen::Vector3d p_V = depth * view.camera->Unproject(pixel.cast<double>());
    f.points_B.push_back((f.T_B_C * p_V).cast<float>());
    f.point_pixels.push_back(pixel);
    f.point_depth_sigmas.push_back(static_cast<float>(k.sigma) / PackedKeypoint::kPerMetre);
    f.point_ids.push_back(static_cast<std::int64_t>(i));
    f.point_descriptors.push_back(view.descriptors[i]);
  }
  return rig;
}

}  // namespace deja_view
