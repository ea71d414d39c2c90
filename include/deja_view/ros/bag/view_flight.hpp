#pragma once

#include "deja_view/camera/camera.hpp"
#include "deja_view/ros/bag/bag_writer.hpp"
#include "deja_view/views/flight_images.hpp"

#include <cstdint>
#include <filesystem>
#include <functional>
#include <memory>
#include <string>

namespace deja_view {

/// What virtual views are rendered for, as messages in the order of recording: a bag, or a folder
/// of images. All calls throw InputError that names the file or topic and what was expected.
class ViewFlight : public FlightImages {
 public:
  /// Topics, types and numbers of messages, a line each; tells flights apart.
  virtual std::string Describe() const = 0;
  /// Looks for what would otherwise come out only in ReadAll, after hours of rendering.
  virtual void CheckContent(int threads) const = 0;

  /// Hands over the time of each message, and what writes it to a bag.
  using WriteMessage = std::function<void(BagWriter* bag)>;
  virtual void ReadAll(const std::function<void(std::int64_t recorded_ns,
                                                const WriteMessage& write)>& visit) const = 0;
};

/// The messages of a bag, byte for byte.
std::shared_ptr<const ViewFlight> OpenBagFlight(const std::filesystem::path& bag);

/// The images of a folder (ListStampedImages) as sensor_msgs/Image on `topic`, mono8 or bgr8,
/// recorded at their stamps, of the camera's size.
std::shared_ptr<const ViewFlight> OpenImageFlight(const std::filesystem::path& directory,
                                                  const std::string& topic,
                                                  std::shared_ptr<const Camera> camera);

}  // namespace deja_view
