#pragma once

#include "deja_view/base/error_policy.hpp"
#include "deja_view/fusion/model_directory.hpp"
#include "deja_view/io/vins_config.hpp"
#include "deja_view/nerf/device.hpp"
#include "deja_view/views/scene_model.hpp"
#include "deja_view/views/view_maker.hpp"
#include "deja_view/views/view_queue.hpp"

#include <atomic>
#include <memory>
#include <mutex>
#include <string>
#include <thread>
#include <vector>

#include <deja_view/NamedMap.h>

#include <nav_msgs/Odometry.h>
#include <ros/callback_queue.h>
#include <ros/node_handle.h>
#include <ros/publisher.h>
#include <ros/service_server.h>
#include <ros/spinner.h>
#include <ros/subscriber.h>
#include <sensor_msgs/CompressedImage.h>
#include <sensor_msgs/Image.h>

namespace deja_view {

/// `deja_view views render` while a bag plays: images and poses in, virtual frames out. Parameters:
///   ~config_file      camera file of VINS or another odometry, required
///   ~preset_file      ViewOptions, relative names of networks are looked for beside it; empty:
///                     defaults
///   ~model_directory  where models are, required
///   ~model            name of the model to start with; empty: wait for ~load_model
///   ~content          image, features or both
///   ~depth            also depth and certainty per pixel
///   ~topics/image, ~topics/pose   images (the YAML's topic) and nav_msgs/Odometry in the frame of
///                     the model's training poses, or where `nerf align` has placed the model
///                     (/vins_estimator/odometry); a model without a scale is refused
///   ~poses_of         body or camera
///   ~compressed_images
///   ~device           auto (a graphics card, or else the CPU), cpu, cuda or cuda:n
///   ~queue_size       images that may wait for the renderer; then the oldest is dropped
/// Publishes /virtual_cam0/frame; offers ~load_model (NamedMap).
class NerfRenderNode {
 public:
  /// Throws InputError when a parameter or file can't be used.
  NerfRenderNode();
  ~NerfRenderNode();

  /// Runs until `stop` is set or ROS shuts down. Returns the exit code. Throws what broke an
  /// invariant, on any thread (ErrorPolicy).
  int Run(const std::atomic<bool>& stop);

 private:
  void Subscribe();
  cv::Size ImageSize() const { return {vins_.camera->width(), vins_.camera->height()}; }
  void OnImage(const sensor_msgs::ImageConstPtr& message);
  void OnCompressedImage(const sensor_msgs::CompressedImageConstPtr& message);
  void OnPose(const nav_msgs::OdometryConstPtr& message);
  bool LoadModel(NamedMap::Request& request, NamedMap::Response& response);
  void Load(const std::string& name);
  void Work();
  void Render(const PosedSource& posed);
  static void OnProblem(const std::string& what);

  ros::NodeHandle handle_;
  ros::NodeHandle private_handle_{"~"};
  ros::CallbackQueue service_queue_;
  ros::NodeHandle service_handle_{"~"};

  VinsConfig vins_;
  ViewOptions options_;
  ViewContent content_;
  ModelDirectory models_;
  nerf::DeviceChoice device_;
  std::string image_topic_;
  std::string pose_topic_;
  bool compressed_images_ = false;
  std::unique_ptr<ViewQueue> queue_;

  /// What a model needs to make views; replaced as a whole.
  struct Scene {
    SceneCells cells;
    Similarity3 N_W;
    ViewRendererFactory renderers;  ///< in the world of the poses
    std::unique_ptr<ViewMaker> maker;
  };
  std::mutex scene_mutex_;
  std::shared_ptr<const Scene> scene_;

  std::atomic<std::int64_t> views_{0};
  std::atomic<std::int64_t> elsewhere_{0};  ///< images whose views another sub-map's field gives
  ErrorPolicy errors_{[this](const std::string& what) { OnProblem(what); }};
  std::thread worker_;
  ros::Publisher publisher_;
  std::vector<ros::Subscriber> subscribers_;
  ros::ServiceServer service_;
  std::unique_ptr<ros::AsyncSpinner> service_spinner_;
};

}  // namespace deja_view
