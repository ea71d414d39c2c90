#include "common/host_choice.hpp"

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
  if (host != HostKind::kOdometry) {
    return std::nullopt;
  }
  return FrontEndSetup{options, vins.camera, vins.T_B_C};
}

void AddHostOptions(CLI::App* sub, HostChoice* choice) {
  sub->add_option_function<std::string>(
      "--host",
      [choice](const std::string& name) {
        const auto host = EnumFromString<HostKind>(name);
        if (!host) {
          throw CLI::ValidationError("--host", name + ": expected " + EnumNameList<HostKind>());
        }
        choice->host = *host;
      },
      "Whose topics the bag has: vins_mono (default), vins_fusion, openvins, or odometry: "
      "keyframes are made of the images and the poses of --odometry-topic");
  sub->add_option("--odometry-topic",
                  choice->odometry_topic,
                  "Body poses (Odometry, PoseStamped, PoseWithCovarianceStamped, "
                  "TransformStamped); the host's without");
}

}  // namespace deja_view
