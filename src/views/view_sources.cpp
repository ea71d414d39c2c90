#include "deja_view/views/view_sources.hpp"

#include "deja_view/base/check.hpp"
#include "deja_view/host/keyframe_assembler.hpp"

#include <algorithm>
#include <iterator>
#include <map>
#include <optional>
#include <set>

namespace deja_view {
namespace {

// Keys (KeyframeAssembler::Key) of the keyframes' stamps; nothing when all images are wanted.
std::optional<std::set<std::int64_t>> KeyframeKeys(const FlightImages& flight,
                                                   const VioTopics& topics,
                                                   SourceKind kind) {
  if (kind == SourceKind::kImages ||
      (kind == SourceKind::kAuto && !flight.HasTopic(topics.keyframe_pose))) {
    return std::nullopt;
  }
  std::set<std::int64_t> keys;
  for (const std::int64_t stamp_ns : flight.KeyframeStamps(topics)) {
    keys.insert(KeyframeAssembler::Key(stamp_ns));
  }
  return keys;
}

void CheckSize(const cv::Mat& image, const Camera& camera, const std::string& topic) {
  if (image.cols != camera.width() || image.rows != camera.height()) {
    ThrowInputError("{}: image of {} x {} px: expected the camera's {} x {}",
                    topic,
                    image.cols,
                    image.rows,
                    camera.width(),
                    camera.height());
  }
}

}  // namespace

SourceImages FindSourceImages(const FlightImages& flight,
                              const VioTopics& topics,
                              SourceKind kind,
                              const Trajectory& T_N_C,
                              std::int64_t max_gap_ns) {
  const std::vector<RecordedImage> recorded = flight.ListImages(topics.image);
  const std::optional<std::set<std::int64_t>> keyframes = KeyframeKeys(flight, topics, kind);
  SourceImages result;
  std::set<std::int64_t> seen;
  for (const RecordedImage& image : recorded) {
    const bool is_wanted =
        !keyframes || keyframes->count(KeyframeAssembler::Key(image.stamp_ns)) > 0;
    if (!is_wanted || !seen.insert(image.stamp_ns).second) {
      continue;
    }
    if (const std::optional<Rigid3> pose = T_N_C.At(image.stamp_ns, max_gap_ns)) {
      result.images.push_back({image.stamp_ns, image.recorded_ns, *pose});
    } else {
      ++result.without_pose;
    }
  }
  if (result.images.empty()) {
    ThrowInputError("{}: none of the {} images on '{}' has a pose: expected poses at their stamps",
                    flight.path().string(),
                    result.without_pose,
                    topics.image);
  }
  return result;
}

std::vector<SourceImage> SelectSourceImages(const std::vector<SourceImage>& images,
                                            const SourceOptions& options) {
  std::vector<Rigid3> poses;
  poses.reserve(images.size());
  for (const SourceImage& image : images) {
    poses.push_back(image.T_N_C);
  }
  std::vector<SourceImage> selected;
  for (const std::size_t i : SelectSources(poses, options)) {
    selected.push_back(images[i]);
  }
  return selected;
}

std::vector<SourceImage> SourceImagesAt(const std::vector<SourceImage>& images,
                                        const std::vector<std::int64_t>& stamps_ns) {
  std::set<std::int64_t> keys;
  for (const std::int64_t stamp_ns : stamps_ns) {
    keys.insert(KeyframeAssembler::Key(stamp_ns));
  }
  std::vector<SourceImage> found;
  std::copy_if(images.begin(), images.end(), std::back_inserter(found), [&](const SourceImage& i) {
    return keys.count(KeyframeAssembler::Key(i.stamp_ns)) > 0;
  });
  if (found.empty()) {
    ThrowInputError("none of the {} images with a pose has one of the {} stamps asked for",
                    images.size(),
                    stamps_ns.size());
  }
  return found;
}

void ReadSourceImages(const FlightImages& flight,
                      const VioTopics& topics,
                      const Camera& camera,
                      const Rigid3& T_B_C,
                      const std::vector<SourceImage>& images,
                      const std::function<void(const LoadedSource&)>& visit) {
  std::map<std::int64_t, SourceImage> wanted;  // by the time of recording
  std::set<std::int64_t> times;
  for (const SourceImage& image : images) {
    wanted[image.recorded_ns] = image;
    times.insert(image.recorded_ns);
  }
  if (wanted.empty()) {
    return;
  }
  const TrackedPoints points = flight.ReadTrackedPoints(topics, camera, T_B_C);
  const auto load = [&](std::int64_t recorded_ns, const DecodedImage& decoded) {
    CheckSize(decoded.image, camera, topics.image);
    const SourceImage& image = wanted.at(recorded_ns);
    LoadedSource loaded;
    loaded.source = {image.stamp_ns, decoded.image, image.T_N_C};
    loaded.recorded_ns = recorded_ns;
    loaded.frame_id = decoded.frame_id;
    const auto found = points.find(KeyframeAssembler::Key(image.stamp_ns));
    loaded.points = found == points.end() ? std::vector<RangeSample>() : found->second;
    visit(loaded);
  };
  flight.ReadImages(topics.image, times, load);
}

}  // namespace deja_view
