#include "deja_view/ros/nodes/loop_fusion_node.hpp"

#include "deja_view/base/check.hpp"
#include "deja_view/base/input_file.hpp"
#include "deja_view/base/output_lock.hpp"
#include "deja_view/fusion/result_files.hpp"
#include "deja_view/io/options_yaml.hpp"
#include "deja_view/ros/nodes/answer_service.hpp"

#include <algorithm>
#include <utility>

#include <ros/console.h>
#include <ros/init.h>

namespace deja_view {
namespace {

// roscpp drops silently what does not fit; the handlers take microseconds, so that these stay
// empty.
constexpr std::uint32_t kImageQueue = 200;
constexpr std::uint32_t kMessageQueue = 2000;

}  // namespace

LoopFusionNode::LoopFusionNode()
    : parameters_(ReadNodeParameters(private_handle_)),
      vins_(ReadVinsConfig(parameters_.config_file)),
      maps_(".") {
  CompleteParameters(vins_, &parameters_);
  maps_ = MapDirectory(parameters_.map_directory);
  if (!parameters_.options_file.empty()) {
    ReadOptions(parameters_.options_file, &options_);
  }
  if (parameters_.host == HostKind::kOdometry) {
    if (const auto frames = ParseTfFrames(parameters_.topics.odometry)) {
      tf_.emplace(*frames);
    }
  }
  service_handle_.setCallbackQueue(&service_queue_);
  publisher_ = std::make_unique<LoopPublisher>(ros::NodeHandle(parameters_.vins_namespace),
                                               private_handle_,
                                               parameters_.frames,
                                               vins_,
                                               options_.node);
  fusion_ = MakeLoopFusion();
  LoadAtStart();
}

LoopFusionNode::~LoopFusionNode() = default;

std::unique_ptr<LoopFusion> LoopFusionNode::MakeLoopFusion() {
  LoopFusionCallbacks callbacks;
  callbacks.on_keyframe =
      [this](const KeyframeInput& input, const KeyframeReport& report, const LoopCloser&) {
        if (!parameters_.output_directory.empty()) {
          AddLoopRows(report.loops, &loops_);
        }
        for (const LoopMatches& matches : report.matches) {
          matches_.Add(matches);
        }
        publisher_->PublishKeyframe(input, report, fusion_->drift());
      };
  callbacks.on_problem = [this](const std::string& what) { OnProblem(what); };
  if (parameters_.host == HostKind::kOdometry) {
    return std::make_unique<LoopFusion>(options_,
                                        MakeLoopCloser(),
                                        std::move(callbacks),
                                        vins_.camera,
                                        vins_.T_B_C,
                                        parameters_.gravity);
  }
  return std::make_unique<LoopFusion>(options_, MakeLoopCloser(), std::move(callbacks));
}

LoopCloser LoopFusionNode::MakeLoopCloser() const {
  const auto vocabulary = Vocabulary::Open(parameters_.vocabulary_file);
  return {options_.loop_closer, vins_.camera, vins_.T_B_C, vocabulary, LoopFusion::RunBeside};
}

void LoopFusionNode::LoadAtStart() {
  // Better now than after the flight.
  if (!parameters_.save_map_at_end.empty()) {
    const auto map = maps_.Resolve(parameters_.save_map_at_end);
    CheckWritable(map.parent_path());
    locks_.push_back(OutputLock::OfFile(map));
  }
  if (!parameters_.output_directory.empty()) {
    CheckWritable(parameters_.output_directory);
    locks_.push_back(OutputLock::OfDirectory(parameters_.output_directory));
  }
  if (!parameters_.load_map_at_start.empty()) {
    Load(maps_.ResolveExisting(parameters_.load_map_at_start));
  } else if (vins_.load_previous_pose_graph) {
    const auto previous = maps_.Resolve(NodeParameters::kPreviousMap);
    if (std::error_code error; std::filesystem::exists(previous, error)) {
      Load(previous);
    } else {
      ROS_WARN("load_previous_pose_graph: there is no %s yet, starting without a map",
               previous.c_str());
    }
  }
}

int LoopFusionNode::Run(const std::atomic<bool>& stop) {
  fusion_->Start();
  Advertise();
  Subscribe();
  ROS_INFO("loop_fusion: waiting for images on %s", parameters_.topics.image.c_str());
  ros::CallbackQueue& queue = *ros::getGlobalCallbackQueue();
  while (!stop && ros::ok() && !HasFailed()) {
    queue.callAvailable(ros::WallDuration(0.1));
  }
  subscribers_.clear();
  errors_.RethrowFailure();
  fusion_->errors().RethrowFailure();
  const bool is_well = Finish();
  service_spinner_->stop();
  return is_well ? 0 : 1;
}

void LoopFusionNode::Advertise() {
  services_.push_back(service_handle_.advertiseService("save_map", &LoopFusionNode::SaveMap, this));
  services_.push_back(service_handle_.advertiseService("load_map", &LoopFusionNode::LoadMap, this));
  timers_.push_back(service_handle_.createWallTimer(
      ros::WallDuration(1.0 / options_.node.path_rate_hz), &LoopFusionNode::PublishPaths, this));
  watch_ = std::make_unique<TopicWatch>(NeededTopics(), ros::SteadyTime::now().toSec());
  timers_.push_back(
      service_handle_.createWallTimer(ros::WallDuration(1.0), &LoopFusionNode::WatchTopics, this));
  diagnosed_at_ = ros::WallTime::now();
  diagnostics_ = std::make_unique<diagnostic_updater::Updater>(service_handle_, private_handle_);
  diagnostics_->setHardwareID("none");
  diagnostics_->add("loop closing", this, &LoopFusionNode::Diagnose);
  timers_.push_back(
      service_handle_.createWallTimer(ros::WallDuration(1.0 / options_.node.diagnostics_rate_hz),
                                      [this](const ros::WallTimerEvent&) {
                                        errors_.Guard([this] { diagnostics_->force_update(); });
                                      }));
  service_spinner_ = std::make_unique<ros::AsyncSpinner>(1, &service_queue_);
  service_spinner_->start();
}

template <typename Message>
void LoopFusionNode::SubscribeTo(
    const std::string& topic,
    std::uint32_t queue,
    void (LoopFusionNode::*handle)(const boost::shared_ptr<const Message>&)) {
  if (topic.empty()) {
    return;  // the host has none
  }
  const boost::function<void(const boost::shared_ptr<const Message>&)> guarded =
      [this, handle, name = handle_.resolveName(topic)](
          const boost::shared_ptr<const Message>& message) {
        watch_->Hear(name, ros::SteadyTime::now().toSec());
        errors_.Guard([&] { (this->*handle)(message); });
      };
  subscribers_.push_back(handle_.subscribe<Message>(
      topic, queue, guarded, ros::VoidConstPtr(), ros::TransportHints().tcpNoDelay()));
}

void LoopFusionNode::Subscribe() {
  const VioTopics& topics = parameters_.topics;
  if (tf_) {
    SubscribeTo(TfPoses::kTopic, kMessageQueue, &LoopFusionNode::OnTransforms);
    SubscribeTo(TfPoses::kStaticTopic, kMessageQueue, &LoopFusionNode::OnStaticTransforms);
  } else if (parameters_.host == HostKind::kOdometry) {
    SubscribeTo(topics.odometry, kMessageQueue, &LoopFusionNode::OnAnyPose);
  } else {
    SubscribeTo(topics.odometry, kMessageQueue, &LoopFusionNode::OnOdometry);
  }
  SubscribeTo(topics.imu_propagate, kMessageQueue, &LoopFusionNode::OnImuPropagate);
  if (!vins_.loop_closure) {
    ROS_WARN("%s: loop_closure is 0: odometry is passed on as it is",
             parameters_.config_file.c_str());
    return;
  }
  if (parameters_.host != HostKind::kOdometry) {
    SubscribeTo(topics.extrinsic, kMessageQueue, &LoopFusionNode::OnExtrinsic);
    SubscribeTo(topics.keyframe_pose, kMessageQueue, &LoopFusionNode::OnKeyframePose);
    SubscribeTo(topics.keyframe_point, kMessageQueue, &LoopFusionNode::OnKeyframePoints);
    SubscribeTo(topics.relo_relative_pose, kMessageQueue, &LoopFusionNode::OnRelativePose);
  }
  SubscribeTo(topics.virtual_frame, kMessageQueue, &LoopFusionNode::OnVirtualFrame);
  if (parameters_.compressed_images) {
    SubscribeTo(topics.image, kImageQueue, &LoopFusionNode::OnCompressedImage);
  } else {
    SubscribeTo(topics.image, kImageQueue, &LoopFusionNode::OnImage);
  }
}

void LoopFusionNode::OnImage(const sensor_msgs::ImageConstPtr& message) {
  AddImage(*message, FromImage(message, parameters_.topics.image, ImageSize()));
}

void LoopFusionNode::OnCompressedImage(const sensor_msgs::CompressedImageConstPtr& message) {
  AddImage(*message, FromCompressedImage(message, parameters_.topics.image, ImageSize()));
}

void LoopFusionNode::OnKeyframePose(const nav_msgs::OdometryConstPtr& message) {
  const StampedPose pose = FromOdometry(*message, parameters_.topics.keyframe_pose);
  fusion_->AddPose(pose.stamp_ns, pose.pose);
}

void LoopFusionNode::OnKeyframePoints(const sensor_msgs::PointCloudConstPtr& message) {
  fusion_->AddPoints(ToNanoseconds(message->header.stamp),
                     FromKeyframePoints(*message, parameters_.topics.keyframe_point));
}

void LoopFusionNode::OnExtrinsic(const nav_msgs::OdometryConstPtr& message) {
  const StampedPose pose = FromOdometry(*message, parameters_.topics.extrinsic);
  fusion_->AddExtrinsic(pose.stamp_ns, pose.pose);
}

void LoopFusionNode::OnOdometry(const nav_msgs::OdometryConstPtr& message) {
  if (IsUninitialised(*message)) {
    ROS_INFO_ONCE("%s: the VIO is not initialised yet", parameters_.topics.odometry.c_str());
    return;
  }
  publisher_->PublishOdometry(
      *message, FromOdometry(*message, parameters_.topics.odometry), fusion_->drift());
}

void LoopFusionNode::OnImuPropagate(const nav_msgs::OdometryConstPtr& message) {
  if (IsUninitialised(*message)) {
    ROS_INFO_ONCE("%s: the VIO is not initialised yet", parameters_.topics.imu_propagate.c_str());
    return;
  }
  publisher_->PublishImuPropagate(
      *message, FromOdometry(*message, parameters_.topics.imu_propagate), fusion_->drift());
}

void LoopFusionNode::OnRelativePose(const nav_msgs::OdometryConstPtr& message) {
  fusion_->AddRelativePose(FromRelativePose(*message, parameters_.topics.relo_relative_pose));
}

void LoopFusionNode::OnVirtualFrame(const VirtualFrameConstPtr& message) {
  const auto decode = [this, message, sufficient = options_.loop_closer.SufficientViewFeatures()] {
    return FromVirtualFrame(*message, parameters_.topics.virtual_frame, sufficient);
  };
  fusion_->AddVirtualView(decode, ros::serialization::serializationLength(*message));
}

bool LoopFusionNode::SaveMap(NamedMap::Request& request, NamedMap::Response& response) {
  return AnswerService("save_map", &errors_, &response, [&] {
    const auto path = maps_.Resolve(request.name);
    return fusion_->WithLoopCloser([&path](const LoopCloser& closer) {
      closer.Save(path);
      return fmt::format("{}: {} keyframes", path.string(), closer.keyframe_count());
    });
  });
}

bool LoopFusionNode::LoadMap(NamedMap::Request& request, NamedMap::Response& response) {
  return AnswerService("load_map", &errors_, &response, [&] {
    const auto path = maps_.ResolveExisting(request.name);
    Load(path);
    return path.string();
  });
}

void LoopFusionNode::Load(const std::filesystem::path& map) {
  CheckInputFile(map / "map.dvm");  // before what else is wrong
  const int keyframes = fusion_->WithLoopCloser([this, &map](LoopCloser& closer) {
    if (const int flown = closer.keyframe_count() - first_own_keyframe_; flown > 0) {
      ThrowInputError(
          "{}: the flight has {} keyframes already, which loading would throw away: load a map "
          "before the first one, or start with ~load_map_at_start",
          map.string(),
          flown);
    }
    closer.Load(map);
    first_own_sequence_ = closer.sequence_count();
    first_own_keyframe_ = closer.keyframe_count();
    return first_own_keyframe_;
  });
  ROS_INFO("loaded %s: %d keyframes", map.c_str(), keyframes);
}

void LoopFusionNode::PublishPaths(const ros::WallTimerEvent& /*event*/) {
  errors_.Guard([this] {
    if (!publisher_->WantsPaths()) {
      return;
    }
    std::vector<LoopReport> loops;
    int first_own_sequence = 0;
    const std::vector<KeyframeInfo> keyframes =
        fusion_->WithLoopCloser([&](const LoopCloser& closer) {
          loops = closer.accepted_loops();
          first_own_sequence = first_own_sequence_;
          return ListKeyframes(closer, options_.node.path_poses);
        });
    publisher_->PublishPaths(keyframes, loops, first_own_sequence);
  });
}

void LoopFusionNode::OnProblem(const std::string& what) {
  ROS_WARN_STREAM_THROTTLE(1.0, "loop_fusion: " << what);
}

bool LoopFusionNode::Finish() {
  const int left = fusion_->Stop(std::chrono::duration<double>(options_.node.drain_s));
  if (left > 0) {
    ROS_WARN(
        "loop_fusion: left %d keyframes unprocessed after %.1f s", left, options_.node.drain_s);
  }
  bool is_well = true;
  try {
    fusion_->WithLoopCloser([this](LoopCloser& closer) {
      const std::vector<LoopReport> withdrawn = closer.OptimizeFully();
      if (!parameters_.save_map_at_end.empty()) {
        closer.Save(maps_.Resolve(parameters_.save_map_at_end));
      }
      if (!parameters_.output_directory.empty()) {
        AddLoopRows(withdrawn, &loops_);
        WriteResultFiles(parameters_.output_directory,
                         ListKeyframes(closer),
                         first_own_keyframe_,
                         loops_,
                         matches_.Sorted());
      }
      return true;
    });
  } catch (const InputError& e) {
    ROS_ERROR("loop_fusion: %s", e.what());
    is_well = false;
  }
  const LoopFusionStatistics statistics = fusion_->statistics();
  const auto accepted = statistics.candidates.find("accepted");
  ROS_INFO("loop_fusion: %ld keyframes, %ld loops, %ld dropped by the queue, %ld bad messages",
           static_cast<long>(statistics.keyframes),
           static_cast<long>(accepted == statistics.candidates.end() ? 0 : accepted->second),
           static_cast<long>(statistics.queue_overflows),
           static_cast<long>(errors_.bad_inputs()));
  return is_well;
}

}  // namespace deja_view
