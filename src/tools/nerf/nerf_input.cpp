#include "nerf/nerf_input.hpp"

#include "deja_view/base/check.hpp"
#include "deja_view/io/colmap.hpp"
#include "deja_view/io/vins_config.hpp"
#include "deja_view/nerf/image_readers.hpp"

#include <utility>

#include "common/pose_input.hpp"
#ifdef DEJA_VIEW_WITH_ROS
#include "common/bag_input.hpp"
#endif

namespace deja_view {
namespace {

using Images = std::vector<nerf::PosedImage>;

// Throws InputError unless exactly one source is given, with what it needs and nothing else.
void CheckSources(const NerfInput& input) {
  const bool has_images = !input.images.empty() && input.colmap.empty();
  const int sources = (has_images ? 1 : 0) + (input.transforms.empty() ? 0 : 1) +
                      (input.colmap.empty() ? 0 : 1) + (input.seven_scenes.empty() ? 0 : 1) +
                      (input.bag.empty() ? 0 : 1);
  if (sources != 1) {
    ThrowInputError(
        "expected one source of images: --images with --camera and --poses, --transforms, "
        "--colmap, --seven-scenes or --bag; found {}",
        sources);
  }
  const bool needs_poses = has_images || !input.bag.empty();
  if (needs_poses && (input.camera.empty() || (input.poses.empty() && input.pose_topic.empty()))) {
    ThrowInputError("--images and --bag need --camera and --poses or --pose-topic");
  }
  if (!needs_poses && !(input.poses.empty() && input.pose_topic.empty())) {
    ThrowInputError("--poses and --pose-topic go with --images or --bag only");
  }
  if (!needs_poses && input.seven_scenes.empty() && !input.camera.empty()) {
    ThrowInputError("--camera goes with --images, --bag or --seven-scenes only");
  }
}

Images ReadTrajectoryInput(const NerfInput& input) {
  const VinsConfig config = ReadVinsConfig(input.camera);
  const PoseSource poses = ReadPoses(
      input.poses.empty() ? input.bag : input.poses, input.pose_topic, input.poses_of == "camera");
  const Rigid3 T_B_C = poses.is_of_camera ? Rigid3::Identity() : config.T_B_C;
  if (!input.bag.empty()) {
#ifdef DEJA_VIEW_WITH_ROS
    const std::string topic = RequireImageTopic(config, input.camera, input.image_topic);
    return nerf::AttachPoses(ListBagInput(input.bag, topic, config.camera),
                             T_B_C,
                             poses.trajectory,
                             input.skip_missing,
                             input.bag.string());
#else
    ThrowInputError("{}: this build reads no bags (DEJA_VIEW_ROS=OFF)", input.bag.string());
#endif
  }
  return nerf::ReadTrajectoryImages(
      input.images, config.camera, T_B_C, poses.trajectory, input.skip_missing);
}

Images ReadImages(const NerfInput& input) {
  if (!input.transforms.empty()) {
    return nerf::ReadTransforms(input.transforms, input.skip_missing);
  }
  if (!input.colmap.empty()) {
    return nerf::ReadColmapImages(input.colmap, input.images, input.skip_missing);
  }
  if (!input.seven_scenes.empty()) {
    return nerf::ReadSevenScenes(
        input.seven_scenes,
        input.skip_missing,
        input.camera.empty() ? nullptr : ReadVinsConfig(input.camera).camera);
  }
  return ReadTrajectoryInput(input);
}

void AddPoints(const std::filesystem::path& bag, Images* images) {
#ifdef DEJA_VIEW_WITH_ROS
  if (nerf::AddVioPoints(ReadBagKeyframes(bag), images) == 0) {
    ThrowInputError("{}: none of its keyframes has the stamp of an image", bag.string());
  }
  nerf::DropStrayPoints(images);
#else
  static_cast<void>(images);
  ThrowInputError("{}: this build reads no bags (DEJA_VIEW_ROS=OFF)", bag.string());
#endif
}

}  // namespace

nerf::Split ReadNerfInput(const NerfInput& input) {
  CheckSources(input);
  Images all = ReadImages(input);
  Images images;
  for (std::size_t i = 0; i < all.size(); i += static_cast<std::size_t>(input.every)) {
    images.push_back(std::move(all[i]));
  }
  if (!input.points.empty()) {
    AddPoints(input.points, &images);
  }
  return nerf::HoldOut(images, input.holdout);
}

nerf::FieldFrame FrameOf(const NerfInput& input) {
  nerf::FieldFrame frame;
  frame.is_known = input.colmap.empty() && !IsColmapModel(input.poses);
  return frame;
}

nerf::LoadOptions MakeLoadOptions(const NerfInput& input, int threads) {
  nerf::LoadOptions options;
  options.scale = input.scale;
  options.max_side = input.max_side;
  options.threads = threads;
  return options;
}

std::vector<nerf::TrainingView> LoadTrainingViews(const NerfInput& input,
                                                  const std::vector<nerf::PosedImage>& images,
                                                  int threads) {
  nerf::LoadOptions options = MakeLoadOptions(input, threads);
  options.channels = input.grey ? 1 : nerf::CountChannels(images);
  return nerf::LoadViews(images, options);
}

}  // namespace deja_view
