#include "common/host_choice.hpp"

#include "deja_view/base/check.hpp"
#include "deja_view/geometry/trajectory_alignment.hpp"
#include "deja_view/ros/bag/bag_poses.hpp"
#include "deja_view/ros/bag/bag_reader.hpp"

#include <functional>

#include "common/pose_input.hpp"
#include <CLI/CLI.hpp>

namespace deja_view {

VioTopics HostChoice::Topics(const VinsConfig& vins, const std::filesystem::path& camera) const {
  VioTopics topics = TopicsOf(host);
  topics.image = RequireImageTopic(vins, camera);
  if (!odometry_topic.empty()) {
    topics.odometry = odometry_topic;
  }
  return topics;
}

std::optional<FrontEndSetup> HostChoice::FrontEnd(const VinsConfig& vins,
                                                  const OdometryFrontEndOptions& options) const {
  const HostKind maker = poses.empty() ? host : HostKind::kOdometry;
  CheckGravity(maker, gravity, "--gravity");
  if (maker != HostKind::kOdometry) {
    return std::nullopt;
  }
  return FrontEndSetup{options, vins.camera, vins.T_B_C, gravity};
}

Trajectory HostChoice::Poses(const VinsConfig& vins, const std::filesystem::path& bag) const {
  if (poses.empty()) {
    return {};
  }
  const PoseSource source = ReadFlightPoses(poses, bag, poses_of == "camera");
  if (!source.is_of_camera) {
    return source.trajectory;
  }
  const Rigid3 T_C_B = vins.T_B_C.Inverse();
  if (source.has_scale) {
    return Transform(source.trajectory, T_C_B);
  }
  const VioTopics topics = TopicsOf(host);
  const bool are_keyframes = odometry_topic.empty() && host != HostKind::kOdometry;
  const std::string host_topic = are_keyframes ? topics.keyframe_pose : topics.odometry;
  const std::string& topic = odometry_topic.empty() ? host_topic : odometry_topic;
  const BagReader reader(bag);
  if (!reader.HasTopic(topic)) {
    ThrowInputError(
        "{}: poses of COLMAP have neither scale nor level: expected {} in {} (or --odometry-topic) "
        "to bring them to, or poses in metres",
        poses,
        topic,
        bag.string());
  }
  const Trajectory T_W_C = Transform(ReadBagPoses(reader, topic), vins.T_B_C);
  AlignmentOptions options;
  options.freedom = AlignmentFreedom::kSimilarity;
  const std::string what = fmt::format("{}, against {} in {}", poses, topic, bag.string());
  const RobustAlignment fit = AlignTrajectories(T_W_C, source.trajectory, options, what);
  return Transform(Transform(fit.A_B, source.trajectory), T_C_B);
}

namespace {

template <typename Enum>
std::function<void(const std::string&)> SetEnum(const std::string& option, Enum* value) {
  return [option, value](const std::string& name) {
    const auto named = EnumFromString<Enum>(name);
    if (!named) {
      throw CLI::ValidationError(option, name + ": expected " + EnumNameList<Enum>());
    }
    *value = *named;
  };
}

}  // namespace

void AddHostOptions(CLI::App* sub, HostChoice* choice) {
  sub->add_option_function<std::string>(
      "--host",
      SetEnum("--host", &choice->host),
      "Whose topics the bag has: vins_mono (default), vins_fusion, openvins, or odometry: "
      "keyframes are made of the images and the poses of --odometry-topic");
  sub->add_option("--odometry-topic",
                  choice->odometry_topic,
                  "Body poses (Odometry, PoseStamped, PoseWithCovarianceStamped, "
                  "TransformStamped), or tf:WORLD,BODY; the host's without");
  sub->add_option_function<std::string>(
      "--gravity",
      SetEnum("--gravity", &choice->gravity),
      "Of --host odometry: given (default), its world's z is up, or estimate: the world is "
      "levelled by the trajectory");
}

void AddHostPosesOptions(CLI::App* sub, HostChoice* choice) {
  sub->add_option("--poses",
                  choice->poses,
                  "Instead of the odometry's: keyframes are made of the images and these. TUM, "
                  "EuRoC's or VINS-Mono's CSV, a COLMAP model, BAG:/topic or /topic");
  sub->add_option("--poses-of", choice->poses_of, "What they are of: body or camera")
      ->check(CLI::IsMember({"body", "camera"}))
      ->capture_default_str();
}

}  // namespace deja_view
