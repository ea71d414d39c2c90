#include "deja_view/ros/nodes/nerf_render_node.hpp"

#include "deja_view/base/check.hpp"
#include "deja_view/base/hash.hpp"
#include "deja_view/io/options_yaml.hpp"
#include "deja_view/ros/messages/conversions.hpp"
#include "deja_view/ros/messages/virtual_frame_conversion.hpp"
#include "deja_view/ros/nodes/answer_service.hpp"
#include "deja_view/scene/open_scene_model.hpp"

#include <utility>

#include "parameters.hpp"

#include <ros/console.h>

namespace deja_view {
namespace {

constexpr std::uint32_t kMessageQueue = 2000;
constexpr std::uint32_t kPublisherQueue = 100;

ViewContent ReadContent(const ros::NodeHandle& handle) {
  const std::string content = internal::ReadText(handle, "content", "image");
  if (content != "image" && content != "features" && content != "both") {
    ThrowInputError("parameter {} is '{}': expected image, features or both",
                    handle.resolveName("content"),
                    content);
  }
  return {content != "features",
          content != "image",
          internal::ReadParameter<bool>(handle, "depth", false, "true or false")};
}

Rigid3 ReadExtrinsic(const ros::NodeHandle& handle, const VinsConfig& vins) {
  const std::string poses_of = internal::ReadText(handle, "poses_of", "body");
  if (poses_of != "body" && poses_of != "camera") {
    ThrowInputError(
        "parameter {} is '{}': expected body or camera", handle.resolveName("poses_of"), poses_of);
  }
  return poses_of == "body" ? vins.T_B_C : Rigid3::Identity();
}

nerf::DeviceChoice ReadDevice(const ros::NodeHandle& handle) {
  const nerf::ChosenDevice chosen =
      nerf::ChooseDevice(internal::ReadText(handle, "device", "auto"));
  if (!chosen.note.empty()) {
    ROS_INFO_STREAM("nerf_render: " << chosen.note);
  }
  return chosen.device;
}

ViewQueueOptions ReadQueueOptions(const ros::NodeHandle& handle) {
  ViewQueueOptions options;
  const int size = internal::ReadParameter<int>(handle, "queue_size", 20, "an integer");
  if (size < 1 || size > 100000) {
    ThrowInputError(
        "parameter {} is {}: expected 1 to 100000", handle.resolveName("queue_size"), size);
  }
  options.max_sources = static_cast<std::size_t>(size);
  return options;
}

}  // namespace

void NerfRenderNode::OnProblem(const std::string& what) {
  ROS_WARN_STREAM_THROTTLE(1.0, "nerf_render: " << what);
}

NerfRenderNode::NerfRenderNode()
    : vins_(ReadVinsConfig(internal::ReadRequired(private_handle_, "config_file"))),
      content_(ReadContent(private_handle_)),
      models_(internal::ReadRequired(private_handle_, "model_directory", "a directory")),
      device_(ReadDevice(private_handle_)),
      image_topic_(internal::ReadText(private_handle_, "topics/image")),
      pose_topic_(internal::ReadText(private_handle_, "topics/pose", "/vins_estimator/odometry")),
      compressed_images_(internal::ReadParameter<bool>(
          private_handle_, "compressed_images", false, "true or false")) {
  image_topic_ = RequireImageTopic(
      vins_, internal::ReadRequired(private_handle_, "config_file"), image_topic_);
  const std::string preset = internal::ReadText(private_handle_, "preset_file");
  if (!preset.empty()) {
    ReadOptions(preset, &options_);
    options_.rendering.network =
        FindNetwork(options_.rendering.network, {std::filesystem::path(preset).parent_path()});
    if (options_.choice.by != ChoiceKind::kSampling) {
      ThrowInputError(
          "{}: choice.by: expected sampling: what all places need together is chosen by "
          "`deja_view views render`",
          preset);
    }
  }
  queue_ = std::make_unique<ViewQueue>(
      ReadQueueOptions(private_handle_), options_.sources, ReadExtrinsic(private_handle_, vins_));
  const std::string model = internal::ReadText(private_handle_, "model");
  if (!model.empty()) {
    Load(model);
  }
  service_handle_.setCallbackQueue(&service_queue_);
}

NerfRenderNode::~NerfRenderNode() {
  queue_->Close();
  if (worker_.joinable()) {
    worker_.join();
  }
}

int NerfRenderNode::Run(const std::atomic<bool>& stop) {
  publisher_ = handle_.advertise<VirtualFrame>("/virtual_cam0/frame", kPublisherQueue);
  service_ = service_handle_.advertiseService("load_model", &NerfRenderNode::LoadModel, this);
  service_spinner_ = std::make_unique<ros::AsyncSpinner>(1, &service_queue_);
  service_spinner_->start();
  worker_ = std::thread([this] { Work(); });
  Subscribe();
  ROS_INFO("nerf_render: waiting for images on %s and poses on %s",
           image_topic_.c_str(),
           pose_topic_.c_str());
  ros::CallbackQueue& callbacks = *ros::getGlobalCallbackQueue();
  while (!stop && ros::ok() && !errors_.has_failed()) {
    callbacks.callAvailable(ros::WallDuration(0.1));
  }
  subscribers_.clear();
  service_spinner_->stop();
  queue_->Close();
  while (queue_->Pop()) {
    // What waits is given up; the view at work is finished.
  }
  worker_.join();
  errors_.RethrowFailure();
  const ViewQueueCounts counts = queue_->counts();
  ROS_INFO(
      "nerf_render: %ld images, %ld without pose, %ld chosen, %ld dropped, %ld of other sub-maps; "
      "%ld views, %ld problems",
      static_cast<long>(counts.images),
      static_cast<long>(counts.without_pose),
      static_cast<long>(counts.sources),
      static_cast<long>(counts.dropped),
      static_cast<long>(elsewhere_),
      static_cast<long>(views_),
      static_cast<long>(errors_.bad_inputs()));
  return 0;
}

void NerfRenderNode::Subscribe() {
  const ros::TransportHints hints = ros::TransportHints().tcpNoDelay();
  subscribers_.push_back(
      handle_.subscribe(pose_topic_, kMessageQueue, &NerfRenderNode::OnPose, this, hints));
  subscribers_.push_back(
      compressed_images_
          ? handle_.subscribe(
                image_topic_, kMessageQueue, &NerfRenderNode::OnCompressedImage, this, hints)
          : handle_.subscribe(image_topic_, kMessageQueue, &NerfRenderNode::OnImage, this, hints));
}

void NerfRenderNode::OnImage(const sensor_msgs::ImageConstPtr& message) {
  errors_.Guard([&] {
    queue_->AddImage(ToNanoseconds(message->header.stamp),
                     message->header.frame_id,
                     FromImage(message, image_topic_, ImageSize()));
  });
}

void NerfRenderNode::OnCompressedImage(const sensor_msgs::CompressedImageConstPtr& message) {
  errors_.Guard([&] {
    queue_->AddImage(ToNanoseconds(message->header.stamp),
                     message->header.frame_id,
                     FromCompressedImage(message, image_topic_, ImageSize()));
  });
}

void NerfRenderNode::OnPose(const nav_msgs::OdometryConstPtr& message) {
  errors_.Guard([&] {
    const StampedPose pose = FromOdometry(*message, pose_topic_);
    queue_->AddPose(pose.stamp_ns, pose.pose);
  });
}

bool NerfRenderNode::LoadModel(NamedMap::Request& request, NamedMap::Response& response) {
  return AnswerService("load_model", &errors_, &response, [&] {
    Load(request.name);
    return models_.Resolve(request.name).string();
  });
}

void NerfRenderNode::Load(const std::string& name) {
  const auto model = OpenSceneModel(models_.Resolve(name), device_);
  const Similarity3 W_N = model->FindFrame(std::nullopt);
  auto scene = std::make_shared<Scene>();
  scene->cells = model->cells();
  scene->N_W = W_N.Inverse();
  scene->renderers = RenderersInWorld(model, W_N);
  const std::string settings = fmt::format("node {} {} {} {}\n{}",
                                           model->Describe(),
                                           W_N.scale,
                                           content_.features,
                                           content_.depth,
                                           OptionsToYaml(options_));
  scene->maker = std::make_unique<ViewMaker>(
      options_, content_, vins_.camera, std::vector<Eigen::Vector3d>(), Hash64(settings));
  const std::lock_guard<std::mutex> lock(scene_mutex_);
  scene_ = std::move(scene);
}

void NerfRenderNode::Work() {
  while (const std::optional<PosedSource> source = queue_->Pop()) {
    errors_.Guard([&] { Render(*source); });
  }
}

void NerfRenderNode::Render(const PosedSource& posed) {
  std::shared_ptr<const Scene> scene;
  {
    const std::lock_guard<std::mutex> lock(scene_mutex_);
    scene = scene_;
  }
  if (scene == nullptr) {
    ThrowInputError("no model is loaded: expected a call of ~load_model first");
  }
  if (!scene->cells.IsOwn(scene->N_W * posed.T_N_C.t)) {
    ++elsewhere_;
    return;
  }
  const ViewSource source{posed.stamp_ns, posed.image(), posed.T_N_C};
  if (source.image.cols != vins_.camera->width() || source.image.rows != vins_.camera->height()) {
    ThrowInputError("{}: image of {} x {} px: expected the camera's {} x {}",
                    image_topic_,
                    source.image.cols,
                    source.image.rows,
                    vins_.camera->width(),
                    vins_.camera->height());
  }
  const MadeViews made = scene->maker->Make(source, *scene->renderers(source, {}), 0);
  if (!made.is_recognised) {
    ThrowInputError("the model does not show the image of stamp {} ns: correlation {:.2f}",
                    posed.stamp_ns,
                    made.fit.correlation);
  }
  for (const VirtualView& view : made.views) {
    publisher_.publish(
        ToVirtualFrame(view, posed.frame_id, {options_.image_format, options_.jpeg_quality}));
    ++views_;
  }
}

}  // namespace deja_view
