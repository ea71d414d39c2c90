#include "common/bag_input.hpp"

#include "deja_view/ros/bag/bag_images.hpp"
#include "deja_view/ros/bag/bag_reader.hpp"

#include <utility>

#include <fmt/format.h>

namespace deja_view {

std::vector<nerf::PosedImage> ListBagInput(const std::filesystem::path& bag,
                                           const std::string& topic,
                                           const std::shared_ptr<const Camera>& camera) {
  std::vector<nerf::PosedImage> images;
  for (BagImage& image : ListBagImages(std::make_shared<const BagReader>(bag), topic)) {
    nerf::PosedImage posed;
    posed.name = std::to_string(image.stamp_ns);
    posed.path = fmt::format("{}:{}:{}", bag.string(), topic, posed.name);
    posed.stamp_ns = image.stamp_ns;
    posed.camera = camera;
    posed.read = std::move(image.read);
    images.push_back(std::move(posed));
  }
  return images;
}

std::vector<nerf::VioKeyframe> ReadBagKeyframes(const std::filesystem::path& bag) {
  std::vector<nerf::VioKeyframe> keyframes;
  for (const BagKeyframe& from : ReadBagKeyframes(BagReader(bag), VioTopics())) {
    nerf::VioKeyframe keyframe;
    keyframe.stamp_ns = from.stamp_ns;
    keyframe.T_W_C = from.T_W_C;
    for (const TrackedPoint& point : from.points) {
      keyframe.pixels.push_back(point.pixel.cast<double>());
      keyframe.p_W.push_back(point.p_W);
    }
    keyframes.push_back(std::move(keyframe));
  }
  return keyframes;
}

}  // namespace deja_view
