#include "deja_view/fusion/match_image.hpp"

#include <algorithm>
#include <map>

#include <fmt/format.h>
#include <opencv2/imgcodecs.hpp>
#include <opencv2/imgproc.hpp>

namespace deja_view {
namespace {

constexpr int kJpegQuality = 75;
constexpr double kScale = 0.5;

cv::Point ToPicture(const Eigen::Vector2d& pixel, int shift) {
  return {static_cast<int>(kScale * pixel.x()) + shift, static_cast<int>(kScale * pixel.y())};
}

}  // namespace

void MatchImages::Add(int index, const cv::Mat& grey) {
  if (memory_ == 0) {
    return;
  }
  cv::Mat small;
  cv::resize(grey, small, {}, kScale, kScale, cv::INTER_AREA);
  std::vector<std::uint8_t> bytes;
  cv::imencode(".jpg", small, bytes, {cv::IMWRITE_JPEG_QUALITY, kJpegQuality});
  bytes.shrink_to_fit();
  if (!pictures_.empty() && index <= pictures_.back().first) {
    pictures_.clear();  // another map was loaded
  }
  pictures_.emplace_back(index, std::move(bytes));
  while (pictures_.size() > static_cast<std::size_t>(memory_)) {
    pictures_.pop_front();
  }
}

std::optional<cv::Mat> MatchImages::Draw(const KeyframeInput& current,
                                         int current_index,
                                         const Relocalisation& relocalisation,
                                         const Camera& camera) const {
  const cv::Mat old_picture = Picture(relocalisation.old);
  const cv::Mat current_picture = Picture(current_index);
  if (old_picture.empty() || current_picture.empty() ||
      old_picture.size() != current_picture.size()) {
    return std::nullopt;
  }
  cv::Mat image;
  cv::hconcat(old_picture, current_picture, image);
  cv::cvtColor(image, image, cv::COLOR_GRAY2BGR);
  std::map<std::int64_t, Eigen::Vector2d> pixels;
  for (const TrackedPoint& point : current.points) {
    pixels[point.feature_id] = point.pixel.cast<double>();
  }
  const int width = old_picture.cols;
  for (const RelocalisationPoint& point : relocalisation.points) {
    const auto pixel = pixels.find(point.feature_id);
    const auto old_pixel = camera.Project(point.normalised_old.homogeneous());
    if (pixel != pixels.end() && old_pixel) {
      const cv::Point from = ToPicture(*old_pixel, 0);
      const cv::Point to = ToPicture(pixel->second, width);
      cv::line(image, from, to, {90, 200, 60}, 1, cv::LINE_AA);
      cv::circle(image, from, 2, {40, 80, 240}, cv::FILLED, cv::LINE_AA);
      cv::circle(image, to, 2, {40, 80, 240}, cv::FILLED, cv::LINE_AA);
    }
  }
  const std::string text = fmt::format(
      "{} - {}: {} points", relocalisation.old, current_index, relocalisation.points.size());
  cv::putText(image, text, {6, 16}, cv::FONT_HERSHEY_SIMPLEX, 0.45, {60, 220, 250}, 1, cv::LINE_AA);
  return image;
}

cv::Mat MatchImages::Picture(int index) const {
  const auto picture = std::lower_bound(
      pictures_.begin(), pictures_.end(), index, [](const auto& p, int i) { return p.first < i; });
  if (picture == pictures_.end() || picture->first != index) {
    return {};
  }
  return cv::imdecode(picture->second, cv::IMREAD_GRAYSCALE);
}

}  // namespace deja_view
