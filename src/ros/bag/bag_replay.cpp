#include "deja_view/ros/bag/bag_replay.hpp"

#include "deja_view/base/check.hpp"
#include "deja_view/ros/bag/bag_reader.hpp"
#include "deja_view/ros/bag/odometry_topic.hpp"
#include "deja_view/ros/bag/view_bag.hpp"
#include "deja_view/ros/messages/virtual_frame_conversion.hpp"

#include <algorithm>
#include <map>
#include <optional>
#include <utility>
#include <vector>

namespace deja_view {
namespace {

class Replay {
 public:
  Replay(const VioTopics& topics,
         const KeyframeAssemblerOptions& options,
         const ReplayCallbacks& callbacks,
         const std::optional<FrontEndSetup>& front_end,
         const Trajectory& T_W_B)
      : topics_(topics),
        callbacks_(callbacks),
        T_W_B_(T_W_B),
        assembler_(
            options,
            [this](const AssembledKeyframe& keyframe) { HandOver(keyframe); },
            [this](DropReason reason, std::int64_t stamp_ns) { TellDrop(reason, stamp_ns); }) {
    if (front_end) {
      front_end_.emplace(
          *front_end,
          [this](OdometryFrontEnd::Keyframe keyframe) {
            assembler_.AddPose(keyframe.stamp_ns, keyframe.T_W_B);
            assembler_.AddPoints(keyframe.stamp_ns, std::move(keyframe.points));
          },
          [this](const std::string& what) { Tell(what); });
    }
  }

  /// `beside`, if any, has the virtual views.
  ReplayReport Run(const BagReader& bag, const BagReader* beside) {
    std::int64_t total = 0;
    std::vector<std::string> names;
    for (const auto& handler : handlers_) {
      const bool is_beside = beside != nullptr && handler.first == topics_.virtual_frame;
      if (!is_beside) {
        names.push_back(handler.first);
      }
      for (const BagReader::Topic& topic : (is_beside ? *beside : bag).topics()) {
        total += topic.name == handler.first ? topic.messages : 0;
      }
    }
    bag.Read(names, beside, {topics_.virtual_frame}, [this, total](const auto& instance) {
      Handle(instance);
      ++report_.messages;
      if (callbacks_.on_progress) {
        callbacks_.on_progress(report_.messages, total);
      }
    });
    if (front_end_) {
      if (last_image_ns_) {
        AddPosesUntil(*last_image_ns_);
      }
      front_end_->Flush();
      report_.front_end = front_end_->counts();
    }
    if (const auto missing = odometry_ ? odometry_->Missing() : std::nullopt) {
      Tell(*missing);
    }
    assembler_.Flush();
    report_.assembler = assembler_.counts();
    return report_;
  }

  void AddHandlers(const BagReader& bag, const BagReader& views) {
    AddImageHandler(bag);
    if (front_end_ && T_W_B_.empty()) {
      AddPoseHandler(bag);
    } else if (!front_end_) {
      AddHostHandlers(bag);
    }
    if (callbacks_.on_virtual_view && views.HasTopic(topics_.virtual_frame)) {
      Require(views, topics_.virtual_frame, "deja_view/VirtualFrame", [this](const auto& instance) {
        const auto message = Instantiate<VirtualFrame>(instance);
        callbacks_.on_virtual_view(
            FromVirtualFrame(*message, instance.getTopic(), callbacks_.sufficient_features));
      });
    }
  }

 private:
  using Handler = std::function<void(const rosbag::MessageInstance&)>;

  static StampedPose ReadOdometry(const rosbag::MessageInstance& instance) {
    return FromOdometry(*Instantiate<nav_msgs::Odometry>(instance), instance.getTopic());
  }

  void AddPoseHandler(const BagReader& bag) {
    odometry_.emplace(bag, topics_.odometry);
    for (const std::string& name : odometry_->names()) {
      handlers_[name] = [this](const rosbag::MessageInstance& instance) {
        if (const auto pose = odometry_->Read(instance)) {
          AddPose(*pose);
        }
      };
    }
  }

  void AddPose(const StampedPose& pose) {
    front_end_->AddPose(pose.stamp_ns, pose.pose);
    if (callbacks_.on_odometry) {
      callbacks_.on_odometry(pose);
    }
  }

  /// Of the given ones, with the first after it.
  void AddPosesUntil(std::int64_t stamp_ns) {
    while (poses_added_ < T_W_B_.size() &&
           (poses_added_ == 0 || T_W_B_.stamps_ns[poses_added_ - 1] < stamp_ns)) {
      AddPose({T_W_B_.stamps_ns[poses_added_], T_W_B_.poses[poses_added_]});
      ++poses_added_;
    }
  }

  /// Poses up to the image before, or to this one if that had a stray stamp that lies ahead.
  void AddPosesFor(std::int64_t stamp_ns) {
    if (last_image_ns_) {
      AddPosesUntil(std::min(*last_image_ns_, stamp_ns));
    }
    last_image_ns_ = stamp_ns;
  }

  void AddHostHandlers(const BagReader& bag) {
    Require(bag, topics_.keyframe_pose, "nav_msgs/Odometry", [this](const auto& instance) {
      const StampedPose pose = ReadOdometry(instance);
      assembler_.AddPose(pose.stamp_ns, pose.pose);
    });
    Require(bag, topics_.keyframe_point, "sensor_msgs/PointCloud", [this](const auto& instance) {
      const auto message = Instantiate<sensor_msgs::PointCloud>(instance);
      assembler_.AddPoints(ToNanoseconds(message->header.stamp),
                           FromKeyframePoints(*message, instance.getTopic()));
    });
    if (callbacks_.on_extrinsic) {
      Want(bag, topics_.extrinsic, [this](const auto& instance) {
        const StampedPose pose = ReadOdometry(instance);
        assembler_.AddExtrinsic(pose.stamp_ns, pose.pose);
      });
    }
    if (callbacks_.on_odometry) {
      Want(bag, topics_.odometry, [this](const auto& instance) {
        callbacks_.on_odometry(ReadOdometry(instance));
      });
    }
    if (callbacks_.on_relative_pose) {
      Want(bag, topics_.relo_relative_pose, [this](const auto& instance) {
        const auto message = Instantiate<nav_msgs::Odometry>(instance);
        callbacks_.on_relative_pose(FromRelativePose(*message, instance.getTopic()));
      });
    }
  }

  void AddImageHandler(const BagReader& bag) {
    RequireImages(bag, topics_.image);
    handlers_[topics_.image] = [this](const rosbag::MessageInstance& instance) {
      const WaitingImage image = ReadImage(instance, callbacks_.image_size);
      assembler_.AddImage(image.stamp_ns, image.source, image.bytes);
      if (front_end_) {
        front_end_->AddImage(image.stamp_ns, image.source, image.bytes);
        AddPosesFor(image.stamp_ns);
      }
    };
  }

  void Require(const BagReader& bag,
               const std::string& topic,
               const std::string& type,
               Handler handler) {
    bag.RequireTopic(topic, {type});
    handlers_[topic] = std::move(handler);
  }

  void Want(const BagReader& bag, const std::string& topic, Handler handler) {
    if (bag.HasTopic(topic)) {
      Require(bag, topic, "nav_msgs/Odometry", std::move(handler));
    }
  }

  void Handle(const rosbag::MessageInstance& instance) {
    try {
      handlers_.at(instance.getTopic())(instance);
    } catch (const InputError& e) {
      Tell(e.what());
    }
  }

  void Tell(const std::string& what) {
    ++report_.bad_messages;
    if (callbacks_.on_problem) {
      callbacks_.on_problem(what);
    }
  }

  void TellDrop(DropReason reason, std::int64_t stamp_ns) {
    if (callbacks_.on_problem) {
      callbacks_.on_problem(
          fmt::format("message of stamp {} ns: {}", stamp_ns, EnumToString(reason)));
    }
  }

  void HandOver(const AssembledKeyframe& keyframe) {
    if (keyframe.is_restart && callbacks_.on_problem) {
      callbacks_.on_problem(RestartText(keyframe.stamp_ns));
    }
    if (callbacks_.on_extrinsic && keyframe.T_B_C && IsNewExtrinsic(*keyframe.T_B_C)) {
      callbacks_.on_extrinsic(*keyframe.T_B_C);
      T_B_C_ = keyframe.T_B_C;
    }
    try {
      callbacks_.on_keyframe(keyframe.ToInput());
    } catch (const InputError& e) {
      Tell(e.what());
    }
  }

  bool IsNewExtrinsic(const Rigid3& T_B_C) const {
    return !T_B_C_ || T_B_C_->t != T_B_C.t || T_B_C_->q.coeffs() != T_B_C.q.coeffs();
  }

  const VioTopics& topics_;
  const ReplayCallbacks& callbacks_;
  const Trajectory& T_W_B_;  // given ones; empty: the topic's
  std::size_t poses_added_ = 0;
  std::optional<std::int64_t> last_image_ns_;
  ReplayReport report_;
  std::optional<Rigid3> T_B_C_;
  std::map<std::string, Handler> handlers_;
  KeyframeAssembler assembler_;
  std::optional<OdometryFrontEnd> front_end_;
  std::optional<OdometryTopic> odometry_;
};

}  // namespace

ReplayReport ReplayBag(const std::filesystem::path& bag,
                       const VioTopics& topics,
                       const KeyframeAssemblerOptions& options,
                       const ReplayCallbacks& callbacks) {
  return ReplayBag(bag, {}, topics, options, callbacks);
}

void RequireVirtualViews(const BagReader& bag, const std::string& frame_topic) {
  if (bag.HasTopic(frame_topic) || !bag.HasTopic(ViewTopics{}.settings)) {
    bag.RequireTopic(frame_topic, {"deja_view/VirtualFrame"});
  }
}

ReplayReport ReplayBag(const std::filesystem::path& bag,
                       const std::filesystem::path& virtual_bag,
                       const VioTopics& topics,
                       const KeyframeAssemblerOptions& options,
                       const ReplayCallbacks& callbacks,
                       const std::optional<FrontEndSetup>& front_end,
                       const Trajectory& T_W_B) {
  DEJA_VIEW_CHECK(callbacks.on_keyframe);
  const BagReader reader(bag);
  std::optional<BagReader> views;
  if (!virtual_bag.empty()) {
    views.emplace(virtual_bag);
    RequireVirtualViews(*views, topics.virtual_frame);
    if (!callbacks.on_virtual_view) {
      views.reset();
    }
  }
  Replay replay(topics, options, callbacks, front_end, T_W_B);
  replay.AddHandlers(reader, views ? *views : reader);
  return replay.Run(reader, views ? &*views : nullptr);
}

}  // namespace deja_view
