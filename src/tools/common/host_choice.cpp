#include "common/host_choice.hpp"

#include <functional>

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
  CheckGravity(host, gravity, "--gravity");
  if (host != HostKind::kOdometry) {
    return std::nullopt;
  }
  return FrontEndSetup{options, vins.camera, vins.T_B_C, gravity};
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

}  // namespace deja_view
