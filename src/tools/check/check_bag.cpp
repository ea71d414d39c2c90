#include "check/check_bag.hpp"

#include "deja_view/base/angles.hpp"
#include "deja_view/host/host_kind.hpp"
#include "deja_view/host/odometry_check.hpp"
#include "deja_view/io/vins_config.hpp"
#include "deja_view/ros/bag/bag_reader.hpp"
#include "deja_view/ros/messages/any_pose.hpp"

#include <algorithm>
#include <cmath>
#include <map>
#include <optional>
#include <set>
#include <utility>

#include <fmt/format.h>

namespace deja_view {
namespace {

using Json = nlohmann::ordered_json;

constexpr std::size_t kKeyframes = 1000;  // whose points are looked at
constexpr double kMostPx = 3;             // of a good calibration's points
constexpr double kMostTiltDeg = 20;       // of a level world
constexpr double kMostSpeedMps = 30;      // of a drone indoors or out, the odometry's jumps apart
constexpr double kLeastPoseHz = 5;        // for poses between which an image's is interpolated
constexpr double kLongGapS = 1;           // after which a new sequence starts

bool IsImage(const std::string& type) {
  return type == "sensor_msgs/Image" || type == "sensor_msgs/CompressedImage";
}

bool IsPose(const std::string& type) {
  const auto& types = PoseMessageTypes();
  return std::find(types.begin(), types.end(), type) != types.end();
}

/// Of the messages with a header that we read.
struct TopicFigures {
  std::string type;
  std::vector<std::int64_t> stamps_ns;
  std::int64_t stamps_back = 0;
  std::vector<Rigid3> poses;  ///< of poses, one per stamp that goes forward
  std::int64_t bad = 0;
  std::string first_problem;
  std::string image_size;

  /// False for a stamp that goes back.
  bool Add(std::int64_t stamp_ns) {
    if (!stamps_ns.empty() && stamp_ns <= stamps_ns.back()) {
      ++stamps_back;
      return false;
    }
    stamps_ns.push_back(stamp_ns);
    return true;
  }
  double duration_s() const {
    return stamps_ns.empty() ? 0.0
                             : 1e-9 * static_cast<double>(stamps_ns.back() - stamps_ns.front());
  }
  double rate_hz() const {
    return duration_s() > 0 ? static_cast<double>(stamps_ns.size() - 1) / duration_s() : 0.0;
  }
  double longest_gap_s() const {
    std::int64_t gap = 0;
    for (std::size_t i = 1; i < stamps_ns.size(); ++i) {
      gap = std::max(gap, stamps_ns[i] - stamps_ns[i - 1]);
    }
    return 1e-9 * static_cast<double>(gap);
  }
};

class BagChecker {
 public:
  explicit BagChecker(const CheckRequest& request) : request_(request), bag_(request.bag) {
    if (!request.camera.empty()) {
      vins_ = ReadVinsConfig(request.camera);
    }
  }

  Json Check() {
    Read();
    Json json;
    json["topics"] = Topics();
    CheckImages();
    json["hosts"] = Hosts();
    if (json["hosts"].empty()) {
      Problem(
          "no host's topics are in it: expected images, and poses (Odometry, PoseStamped, "
          "PoseWithCovarianceStamped or TransformStamped)");
    }
    json["problems"] = problems_;
    return json;
  }

 private:
  void Problem(const std::string& what) { problems_.push_back(what); }

  void Read() {
    std::vector<std::string> names;
    for (const BagReader::Topic& topic : bag_.topics()) {
      if (IsImage(topic.type) || IsPose(topic.type) || topic.type == "sensor_msgs/PointCloud") {
        names.push_back(topic.name);
        figures_[topic.name].type = topic.type;
      }
    }
    bag_.Read(names, [this](const rosbag::MessageInstance& instance) {
      TopicFigures& figures = figures_[instance.getTopic()];
      try {
        ReadMessage(instance, &figures);
      } catch (const InputError& error) {
        figures.first_problem = figures.bad++ == 0 ? error.what() : figures.first_problem;
      }
    });
  }

  void ReadMessage(const rosbag::MessageInstance& instance, TopicFigures* figures) {
    const std::string& topic = instance.getTopic();
    if (const auto image = internal::InstantiateIf<sensor_msgs::Image>(instance)) {
      figures->Add(ToNanoseconds(image->header.stamp));
      FromImage(image, topic);
      figures->image_size = fmt::format("{} x {}", image->width, image->height);
    } else if (const auto jpeg = internal::InstantiateIf<sensor_msgs::CompressedImage>(instance)) {
      const bool is_first = figures->stamps_ns.empty();
      figures->Add(ToNanoseconds(jpeg->header.stamp));
      if (is_first) {
        const cv::Mat pixels = FromCompressedImage(jpeg, topic)();
        figures->image_size = fmt::format("{} x {}", pixels.cols, pixels.rows);
      }
    } else if (const auto cloud = internal::InstantiateIf<sensor_msgs::PointCloud>(instance)) {
      figures->Add(ToNanoseconds(cloud->header.stamp));
      auto& points = points_[topic];
      points[figures->stamps_ns.back()] = points.size() < kKeyframes
                                              ? FromKeyframePoints(*cloud, topic)
                                              : std::vector<TrackedPoint>();
    } else if (const auto pose = FromAnyPose(instance, topic)) {
      if (figures->Add(pose->stamp_ns)) {
        figures->poses.push_back(pose->pose);
      }
    }
  }

  Json Topics() {
    Json list = Json::array();
    for (const BagReader::Topic& topic : bag_.topics()) {
      Json json = {{"name", topic.name}, {"type", topic.type}, {"messages", topic.messages}};
      const auto found = figures_.find(topic.name);
      if (found != figures_.end()) {
        const TopicFigures& figures = found->second;
        json["rate_hz"] = figures.rate_hz();
        json["longest_gap_s"] = figures.longest_gap_s();
        json["stamps_back"] = figures.stamps_back;
        if (!figures.image_size.empty()) {
          json["size"] = figures.image_size;
        }
        if (figures.bad > 0) {
          Problem(fmt::format("{} of {} messages can't be used: {}",
                              figures.bad,
                              topic.messages,
                              figures.first_problem));
        }
        if (figures.stamps_back > 0) {
          Problem(
              fmt::format("{}: {} stamps go back or stand still: was the odometry restarted, "
                          "or are two flights in the bag?",
                          topic.name,
                          figures.stamps_back));
        }
      }
      list.push_back(json);
    }
    return list;
  }

  void CheckImages() {
    if (!vins_) {
      return;
    }
    const auto found = figures_.find(vins_->image_topic);
    if (vins_->image_topic.empty()) {
      Problem(fmt::format("{}: names no image topic: add a line 'image_topic: ...'",
                          request_.camera.string()));
    } else if (found == figures_.end() || !IsImage(found->second.type)) {
      Problem(fmt::format(
          "no images on {}, the image topic of {}", vins_->image_topic, request_.camera.string()));
    } else {
      const std::string size =
          fmt::format("{} x {}", vins_->camera->width(), vins_->camera->height());
      if (found->second.image_size != size) {
        Problem(fmt::format("{}: images of {} px: expected the camera's {}",
                            vins_->image_topic,
                            found->second.image_size,
                            size));
      }
      if (found->second.longest_gap_s() > kLongGapS) {
        Problem(fmt::format("{}: a gap of {:.1f} s: a new sequence starts after it",
                            vins_->image_topic,
                            found->second.longest_gap_s()));
      }
    }
  }

  bool Has(const std::string& topic) const {
    const auto found = figures_.find(topic);
    return found != figures_.end() && !found->second.stamps_ns.empty();
  }

  Json Hosts() {
    Json hosts = Json::array();
    const std::string files = fmt::format("--bag {} --camera {}",
                                          request_.bag.string(),
                                          vins_ ? request_.camera.string() : "CAMERA.yaml");
    for (const HostKind host : {HostKind::kVinsMono, HostKind::kOpenVins}) {
      const VioTopics topics = TopicsOf(host);
      if (Has(topics.keyframe_pose) && Has(topics.keyframe_point)) {
        hosts.push_back(
            {{"host", EnumToString(host)},
             {"command", fmt::format("deja_view replay {} --host {}", files, EnumToString(host))}});
        CheckKeyframes(topics);
      }
    }
    const bool has_images = std::any_of(figures_.begin(), figures_.end(), [](const auto& f) {
      return IsImage(f.second.type) && !f.second.stamps_ns.empty();
    });
    std::vector<std::string> tilted;
    for (const auto& [name, figures] : figures_) {
      if (!IsOfAFlight(figures)) {
        continue;
      }
      CheckSpeed(name, figures);
      const std::string problem = TiltProblem(name, figures);
      const bool is_odometry = figures.rate_hz() >= kLeastPoseHz && !IsKeyframeTopic(name);
      if (!problem.empty()) {
        tilted.push_back(problem);
      } else if (has_images && is_odometry) {
        hosts.push_back(
            {{"host", "odometry"},
             {"command",
              fmt::format(
                  "deja_view replay {} --host odometry --odometry-topic {}", files, name)}});
      }
    }
    // Beside a level one, another pose may be of what it likes, as a camera's.
    if (hosts.empty() || hosts.back()["host"] != "odometry") {
      problems_.insert(problems_.end(), tilted.begin(), tilted.end());
    }
    return hosts;
  }

  static bool IsKeyframeTopic(const std::string& name) {
    return name == TopicsOf(HostKind::kVinsMono).keyframe_pose ||
           name == TopicsOf(HostKind::kOpenVins).keyframe_pose;
  }

  /// False for a calibration, and for a drone that stands.
  static bool IsOfAFlight(const TopicFigures& figures) {
    return std::any_of(figures.poses.begin(), figures.poses.end(), [&](const Rigid3& pose) {
      return (pose.t - figures.poses.front().t).norm() > 0.02;
    });
  }

  void CheckSpeed(const std::string& name, const TopicFigures& figures) {
    const MotionFigures motion = MeasureMotion(figures.stamps_ns, figures.poses);
    if (motion.max_mps > kMostSpeedMps) {
      Problem(
          fmt::format("{}: up to {:.0f} m/s over {:.0f} m: the odometry jumps, or is not in "
                      "metres",
                      name,
                      motion.max_mps,
                      motion.path_m));
    }
  }

  /// Empty for a world that is level, or of which nothing can be said.
  std::string TiltProblem(const std::string& name, const TopicFigures& figures) const {
    if (!vins_) {
      return {};
    }
    std::vector<Rigid3> T_W_C;
    for (const Rigid3& T_W_B : figures.poses) {
      T_W_C.push_back(T_W_B * vins_->T_B_C);
    }
    const auto up = UpFromLevelRows(T_W_C);
    const double tilt_deg = up ? ToDegrees(std::acos(std::min(1.0, std::abs(up->z())))) : 0.0;
    if (tilt_deg <= kMostTiltDeg) {
      return {};
    }
    return fmt::format(
        "{}: its world is tilted by {:.0f} degrees, if the camera is held upright: expected z up; "
        "or the extrinsics of {} are another camera's",
        name,
        tilt_deg,
        request_.camera.string());
  }

  void CheckKeyframes(const VioTopics& topics) {
    const TopicFigures& keyframes = figures_.at(topics.keyframe_pose);
    const auto& points = points_[topics.keyframe_point];
    std::vector<double> errors_px;
    std::size_t without_points = 0;
    for (std::size_t i = 0; i < keyframes.poses.size(); ++i) {
      const auto of_keyframe = points.find(keyframes.stamps_ns[i]);
      if (of_keyframe == points.end()) {
        ++without_points;
      } else if (vins_) {
        const auto error_px = MedianReprojection(
            keyframes.poses[i] * vins_->T_B_C, of_keyframe->second, *vins_->camera);
        if (error_px) {
          errors_px.push_back(*error_px);
        }
      }
    }
    if (without_points > 0) {
      Problem(fmt::format("{} of {} keyframes have no points on {}",
                          without_points,
                          keyframes.poses.size(),
                          topics.keyframe_point));
    }
    if (!errors_px.empty()) {
      std::sort(errors_px.begin(), errors_px.end());
      const double median_px = errors_px[errors_px.size() / 2];
      if (median_px > kMostPx) {
        Problem(
            fmt::format("{}: the tracked points miss their pixels by {:.1f} px (median): "
                        "expected under {:.0f}; calibration or extrinsics of {} are not "
                        "those of this flight",
                        topics.keyframe_point,
                        median_px,
                        kMostPx,
                        request_.camera.string()));
      }
    }
  }

  const CheckRequest& request_;
  BagReader bag_;
  std::optional<VinsConfig> vins_;
  std::map<std::string, TopicFigures> figures_;
  std::map<std::string, std::map<std::int64_t, std::vector<TrackedPoint>>> points_;  ///< by stamp
  std::vector<std::string> problems_;
};

}  // namespace

Json CheckBag(const CheckRequest& request) {
  return BagChecker(request).Check();
}

}  // namespace deja_view
