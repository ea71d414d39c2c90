#pragma once

#include "deja_view/features/feature_extractor.hpp"
#include "deja_view/pipeline/loop_closer_options.hpp"
#include "deja_view/verification/loop_verifier.hpp"
#include "deja_view/views/virtual_view.hpp"

#include <cstddef>
#include <cstdint>
#include <memory>
#include <optional>
#include <vector>

namespace deja_view {

/// A keypoint of a virtual view in 8 bytes.
struct PackedKeypoint {
  static constexpr float kPerPixel = 16.0F;    ///< steps of a sixteenth of a pixel, up to 4095 px
  static constexpr float kPerMetre = 1000.0F;  ///< millimetres, up to 65 m

  std::uint16_t u = 0;
  std::uint16_t v = 0;
  std::uint16_t depth = 0;  ///< along the unit ray; 0: unknown
  std::uint16_t sigma = 0;
};

/// A virtual view as it is kept: its features alone.
struct StoredView {
  std::int32_t index = 0;
  Rigid3 T_C_V;
  std::shared_ptr<const Camera> camera;
  std::vector<PackedKeypoint> keypoints;
  std::vector<Descriptor> descriptors;
  double similarity = -1.0;  ///< to its source image; -1: not computed yet

  std::size_t MemoryBytes() const {
    return keypoints.capacity() * sizeof(PackedKeypoint) +
           descriptors.capacity() * sizeof(Descriptor);
  }
};

/// Throws InputError, naming stamp and field, when the view's parts do not fit each other or it has
/// nothing that `descriptor_name` could be compared with.
void CheckView(const VirtualView& view, const std::string& descriptor_name);

/// Features of a view that passed CheckView, from its message or its image: the strongest
/// `options.max_features` of those that are certain. Of a message's own, only those whose patch was
/// turned as `vertical`, the view's, says, or by ORB's own measure where it is empty; its image
/// serves where most of them were turned otherwise.
StoredView MakeStoredView(const VirtualView& view,
                          const FeatureExtractor& extractor,
                          const VerticalField& vertical,
                          const VirtualViewOptions& options);

/// The view as a camera of its keyframe's rig; points are the keypoints of certain depth.
RigCamera ToRigCamera(const StoredView& view,
                      const Rigid3& T_B_C,
                      const VirtualViewOptions& options);

}  // namespace deja_view
