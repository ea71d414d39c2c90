#pragma once

#include "deja_view/base/enum_names.hpp"
#include "deja_view/camera/camera.hpp"
#include "deja_view/features/types.hpp"
#include "deja_view/geometry/rigid3.hpp"

#include <cstdint>
#include <memory>
#include <string>
#include <vector>

#include <opencv2/core/mat.hpp>

namespace deja_view {

/// How the image of a view is compressed in its message.
enum class ImageFormat { kJpeg, kPng };

template <>
inline constexpr auto kEnumNames<ImageFormat> = EnumNames("jpeg", "png");

/// Features of a virtual view that were extracted offline, so that a drone need not. All lists have
/// the same length.
struct VirtualFeatures {
  std::string descriptor;            ///< "brief" or "orb"; empty: there are none
  Features features;                 ///< [px] in the virtual camera
  std::vector<float> depth_m;        ///< along the unit ray; 0: unknown
  std::vector<float> depth_sigma_m;  ///< standard deviation of depth_m; 0 where that is unknown
};

/// What the camera would have seen from a pose beside one real image's (Sec. 3.2.2). It has an
/// image, or features, or both.
struct VirtualView {
  std::int64_t stamp_ns = 0;             ///< of the source image
  std::int32_t index = 0;                ///< among the source image's views, from 0
  std::int32_t count = 0;                ///< how many views the source image has; 0: unknown
  Rigid3 T_C_V;                          ///< the virtual camera's pose in the real camera [m]
  std::shared_ptr<const Camera> camera;  ///< of the virtual view
  cv::Mat image;                         ///< CV_8UC1, the camera's size; may be empty
  cv::Mat depth_mm;   ///< CV_16UC1, the image's size, along the unit ray; 0: unknown; may be empty
  cv::Mat certainty;  ///< CV_8UC1, the image's size, 255: certain, 0: unknown; may be empty
  VirtualFeatures features;
  std::uint64_t settings_hash = 0;  ///< of what made it: model, sampling, rendering
};

}  // namespace deja_view
