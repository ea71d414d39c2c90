#pragma once

#include "deja_view/base/enum_names.hpp"
#include "deja_view/geometry/trajectory.hpp"
#include "deja_view/views/depth_warp_renderer.hpp"
#include "deja_view/views/flight_images.hpp"
#include "deja_view/views/view_maker.hpp"

#include <cstdint>
#include <functional>
#include <string>
#include <vector>

namespace deja_view {

/// Which images of a flight may get views.
enum class SourceKind {
  kAuto,       ///< keyframes where the flight has them, all images otherwise
  kKeyframes,  ///< images with the stamp of a keyframe pose
  kImages,     ///< all
};

template <>
inline constexpr auto kEnumNames<SourceKind> = EnumNames("auto", "keyframes", "images");

/// An image of a flight with a pose.
struct SourceImage {
  std::int64_t stamp_ns = 0;     ///< of its header
  std::int64_t recorded_ns = 0;  ///< when the flight says it came
  Rigid3 T_N_C;
};

/// Images of a flight that have a pose at their stamp, in the order of recording, each stamp once.
struct SourceImages {
  std::vector<SourceImage> images;
  std::int64_t without_pose = 0;
};

/// Finds the images; their poses are interpolated over at most `max_gap_ns`. Throws InputError when
/// the flight lacks a topic that is needed, and when no image has a pose.
SourceImages FindSourceImages(const FlightImages& flight,
                              const VioTopics& topics,
                              SourceKind kind,
                              const Trajectory& T_N_C,
                              std::int64_t max_gap_ns = 100'000'000);

/// Those that get views (SelectSources), in order.
std::vector<SourceImage> SelectSourceImages(const std::vector<SourceImage>& images,
                                            const SourceOptions& options);

/// The images at these stamps, to within VIOs' rounding. Throws InputError when there is none.
std::vector<SourceImage> SourceImagesAt(const std::vector<SourceImage>& images,
                                        const std::vector<std::int64_t>& stamps_ns);

/// An image of a flight, decoded.
struct LoadedSource {
  ViewSource source;
  std::int64_t recorded_ns = 0;
  std::string frame_id;
  std::vector<RangeSample> points;  ///< the VIO's tracked points, if it was a keyframe
};

/// Decodes `images`, in the order of recording, and hands over one after the other. Throws
/// InputError that names the topic for an image of another size than the camera's.
void ReadSourceImages(const FlightImages& flight,
                      const VioTopics& topics,
                      const Camera& camera,
                      const Rigid3& T_B_C,
                      const std::vector<SourceImage>& images,
                      const std::function<void(const LoadedSource&)>& visit);

}  // namespace deja_view
