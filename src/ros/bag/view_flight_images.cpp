#include "deja_view/base/check.hpp"
#include "deja_view/base/parallel.hpp"
#include "deja_view/io/image_files.hpp"
#include "deja_view/ros/bag/view_flight.hpp"
#include "deja_view/ros/messages/conversions.hpp"

#include <utility>

#include <opencv2/imgcodecs.hpp>

namespace deja_view {
namespace {

namespace fs = std::filesystem;

constexpr const char* kFrameId = "cam0";

void CheckStamps(const std::vector<StampedImage>& images) {
  constexpr std::int64_t kEnd_ns = 4'294'967'296'000'000'000;  // 32 bits of seconds
  for (const StampedImage& image : {images.front(), images.back()}) {
    if (image.stamp_ns < 1 || image.stamp_ns >= kEnd_ns) {
      ThrowInputError("{}: stamp {} ns: expected 1 ns to {} ns, as ROS can tell",
                      image.path.string(),
                      image.stamp_ns,
                      kEnd_ns - 1);
    }
  }
}

class ImageFlight final : public ViewFlight {
 public:
  ImageFlight(fs::path directory, std::string topic, std::shared_ptr<const Camera> camera)
      : directory_(std::move(directory)),
        topic_(std::move(topic)),
        camera_(std::move(camera)),
        images_(ListStampedImages(directory_)) {
    CheckStamps(images_);
  }

  const fs::path& path() const override { return directory_; }
  bool HasTopic(const std::string& topic) const override { return topic == topic_; }
  std::string Describe() const override {
    return fmt::format("{} sensor_msgs/Image {}\n", topic_, images_.size());
  }

  void CheckContent(int threads) const override {
    ParallelFor(threads, images_.size(), [this](std::size_t begin, std::size_t end) {
      for (std::size_t i = begin; i < end; ++i) {
        Read(images_[i]);
      }
    });
  }

  std::vector<RecordedImage> ListImages(const std::string& topic) const override {
    RequireTopic(topic);
    std::vector<RecordedImage> images;
    for (const StampedImage& image : images_) {
      images.push_back({image.stamp_ns, image.stamp_ns});
    }
    return images;
  }

  void ReadImages(
      const std::string& topic,
      const std::set<std::int64_t>& recorded_ns,
      const std::function<void(std::int64_t, const DecodedImage&)>& visit) const override {
    RequireTopic(topic);
    for (const StampedImage& image : images_) {
      if (recorded_ns.count(image.stamp_ns) > 0) {
        // The very conversion that the image gets when it comes from the new bag.
        const auto message = boost::make_shared<const sensor_msgs::Image>(MakeMessage(image));
        visit(image.stamp_ns, {FromImage(message, image.path.string())(), kFrameId});
      }
    }
  }

  std::vector<std::int64_t> KeyframeStamps(const VioTopics& /*topics*/) const override {
    ThrowInputError("{}: a folder of images tells no keyframes: expected all images as sources",
                    directory_.string());
  }

  TrackedPoints ReadTrackedPoints(const VioTopics& /*topics*/,
                                  const Camera& /*camera*/,
                                  const Rigid3& /*T_B_C*/) const override {
    return {};
  }

  void ReadAll(const std::function<void(std::int64_t, const WriteMessage&)>& visit) const override {
    for (const StampedImage& image : images_) {
      visit(image.stamp_ns, [this, &image](BagWriter* out) {
        out->Write(topic_, image.stamp_ns, MakeMessage(image));
      });
    }
  }

 private:
  void RequireTopic(const std::string& topic) const {
    if (topic != topic_) {
      ThrowInputError(
          "{}: no topic '{}': its images are on '{}'", directory_.string(), topic, topic_);
    }
  }

  cv::Mat Read(const StampedImage& image) const {
    cv::Mat pixels =
        cv::imread(image.path.string(), cv::IMREAD_ANYCOLOR | cv::IMREAD_IGNORE_ORIENTATION);
    if (pixels.empty()) {
      ThrowInputError("{}: can't be read as an image", image.path.string());
    }
    if (pixels.cols != camera_->width() || pixels.rows != camera_->height()) {
      ThrowInputError("{}: image of {} x {} px: expected the camera's {} x {}",
                      image.path.string(),
                      pixels.cols,
                      pixels.rows,
                      camera_->width(),
                      camera_->height());
    }
    return pixels;
  }

  sensor_msgs::Image MakeMessage(const StampedImage& image) const {
    return ToImage(Read(image), image.stamp_ns, kFrameId);
  }

  fs::path directory_;
  std::string topic_;
  std::shared_ptr<const Camera> camera_;
  std::vector<StampedImage> images_;  // sorted by stamp, not empty
};

}  // namespace

std::shared_ptr<const ViewFlight> OpenImageFlight(const fs::path& directory,
                                                  const std::string& topic,
                                                  std::shared_ptr<const Camera> camera) {
  return std::make_shared<ImageFlight>(directory, topic, std::move(camera));
}

}  // namespace deja_view
