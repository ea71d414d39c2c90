#pragma once

#include "deja_view/VirtualFrame.h"
#include "deja_view/views/virtual_view.hpp"

#include <string>

namespace deja_view {

struct VirtualFrameEncoding {
  ImageFormat image_format = ImageFormat::kJpeg;
  int jpeg_quality = 90;  ///< 1 to 100
};

/// The view as a message; the same bytes for the same view. `frame_id` is the real camera's frame.
/// Throws CheckError for a view without a camera, without image and features, or with parts of
/// sizes that do not agree.
VirtualFrame ToVirtualFrame(const VirtualView& view,
                            const std::string& frame_id,
                            const VirtualFrameEncoding& encoding = {});

/// What a message holds, decoded. Throws InputError that names the topic, the field, its value and
/// what was expected: a pose that is none, an impossible camera, an image that can't be decoded or
/// is of another size than the camera (found out before any memory is taken for its pixels), lists
/// of different lengths, keypoints outside the image, numbers that are not finite or negative
/// depths. Of a message with features of the kind `sufficient_features` ("brief" or "orb"; empty:
/// none) the images are not decoded.
VirtualView FromVirtualFrame(const VirtualFrame& message,
                             const std::string& topic,
                             const std::string& sufficient_features = "");

}  // namespace deja_view
