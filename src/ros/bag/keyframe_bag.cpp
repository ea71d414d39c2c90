#include "deja_view/ros/bag/keyframe_bag.hpp"

#include "deja_view/base/check.hpp"
#include "deja_view/host/vio_topics.hpp"
#include "deja_view/ros/bag/bag_reader.hpp"
#include "deja_view/ros/bag/bag_writer.hpp"
#include "deja_view/ros/bag/odometry_topic.hpp"
#include "deja_view/ros/messages/conversions.hpp"

#include <algorithm>
#include <system_error>
#include <utility>
#include <vector>

namespace deja_view {
namespace {

cv::Size SizeOf(const Camera& camera) {
  return {camera.width(), camera.height()};
}

class KeyframeBag {
 public:
  explicit KeyframeBag(const KeyframeBagJob& job)
      : job_(job),
        reader_(job.bag),
        odometry_(reader_, job.odometry_topic),
        writer_(job.out),
        front_end_(
            job.front_end,
            [this](const OdometryFrontEnd::Keyframe& keyframe) { Write(keyframe); },
            [this](const std::string& what) { Tell(what); }),
        names_(odometry_.names()) {
    RequireImages(reader_, job.image_topic);
    names_.push_back(job.image_topic);
    if (job.front_end.second) {
      RequireImages(reader_, job.second_image_topic);
      names_.push_back(job.second_image_topic);
    }
  }

  FrontEndCounts Run() {
    std::int64_t total = 0;
    for (const BagReader::Topic& topic : reader_.topics()) {
      total += std::count(names_.begin(), names_.end(), topic.name) > 0 ? topic.messages : 0;
    }
    std::int64_t done = 0;
    reader_.Read(names_, [&](const rosbag::MessageInstance& instance) {
      now_ns_ = ToNanoseconds(instance.getTime());
      try {
        Handle(instance);
      } catch (const InputError& e) {
        Tell(e.what());
      }
      if (job_.on_progress) {
        job_.on_progress(++done, total);
      }
    });
    front_end_.Flush();
    if (const auto missing = odometry_.Missing()) {
      Tell(*missing);
    }
    writer_.Close();
    return front_end_.counts();
  }

 private:
  void Handle(const rosbag::MessageInstance& instance) {
    if (instance.getTopic() == job_.image_topic) {
      writer_.Copy(instance);
      WaitingImage image = ReadImage(instance, SizeOf(*job_.front_end.camera));
      front_end_.AddImage(image.stamp_ns, std::move(image.source), image.bytes);
    } else if (instance.getTopic() == job_.second_image_topic) {
      WaitingImage image = ReadImage(instance, SizeOf(*job_.front_end.second->camera));
      front_end_.AddSecondImage(image.stamp_ns, std::move(image.source), image.bytes);
    } else if (const auto pose = odometry_.Read(instance)) {
      writer_.Write(topics_.odometry, now_ns_, ToOdometry(*pose));
      front_end_.AddPose(pose->stamp_ns, pose->pose);
    }
  }

  void Write(const OdometryFrontEnd::Keyframe& keyframe) {
    const std::int64_t stamp_ns = keyframe.stamp_ns;
    writer_.Write(topics_.extrinsic, now_ns_, ToOdometry({stamp_ns, job_.front_end.T_B_C}));
    writer_.Write(topics_.keyframe_pose, now_ns_, ToOdometry({stamp_ns, keyframe.T_W_B}));
    writer_.Write(topics_.keyframe_point,
                  now_ns_,
                  ToKeyframePoints(stamp_ns, keyframe.points, *job_.front_end.camera));
  }

  void Tell(const std::string& what) const {
    if (job_.on_problem) {
      job_.on_problem(what);
    }
  }

  const KeyframeBagJob& job_;
  const VioTopics topics_;
  BagReader reader_;
  OdometryTopic odometry_;
  BagWriter writer_;
  OdometryFrontEnd front_end_;
  std::vector<std::string> names_;
  std::int64_t now_ns_ = 0;  ///< when the message at hand was recorded
};

}  // namespace

FrontEndCounts WriteKeyframeBag(const KeyframeBagJob& job) {
  DEJA_VIEW_CHECK(job.front_end.second.has_value() == !job.second_image_topic.empty());
  std::error_code error;
  if (std::filesystem::equivalent(job.bag, job.out, error)) {
    ThrowInputError("{}: expected another bag than the one that is read", job.out.string());
  }
  return KeyframeBag(job).Run();
}

}  // namespace deja_view
