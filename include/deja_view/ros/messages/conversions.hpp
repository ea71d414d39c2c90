#pragma once

#include "deja_view/camera/camera.hpp"
#include "deja_view/geometry/rigid3.hpp"
#include "deja_view/host/image_source.hpp"
#include "deja_view/host/odometry_input.hpp"
#include "deja_view/pipeline/loop_closer.hpp"

#include <cstdint>
#include <optional>
#include <string>
#include <vector>

#include <opencv2/core/mat.hpp>

#include <geometry_msgs/Pose.h>
#include <nav_msgs/Odometry.h>
#include <sensor_msgs/CompressedImage.h>
#include <sensor_msgs/Image.h>
#include <sensor_msgs/PointCloud.h>

/// VINS-Mono's border: the only place that knows how its messages use their fields. What comes in
/// is checked here; all functions that take a `topic` throw InputError that names it, the value and
/// what was expected.
namespace deja_view {

/// A malformed stamp beyond what ToRosTime takes is the latest that it takes.
std::int64_t ToNanoseconds(const ros::Time& stamp);
/// Throws CheckError outside what ros::Time can hold (1970 to 2106).
ros::Time ToRosTime(std::int64_t stamp_ns);

/// All numbers finite, quaternion of norm 1 +- 0.01; the result is normalised.
Rigid3 FromPose(const geometry_msgs::Pose& pose, const std::string& topic);
geometry_msgs::Pose ToPose(const Rigid3& pose);

/// Whether the orientation is all zeros, as VINS-Mono's is until it is initialised.
bool IsUninitialised(const nav_msgs::Odometry& message);

StampedPose FromOdometry(const nav_msgs::Odometry& message, const std::string& topic);

/// One channel per point with [x_n, y_n, u, v, feature id]. Points or pixels that are not finite
/// are left out.
std::vector<TrackedPoint> FromKeyframePoints(const sensor_msgs::PointCloud& message,
                                             const std::string& topic);

RelativePoseUpdate FromRelativePose(const nav_msgs::Odometry& message, const std::string& topic);

/// What FromOdometry and FromKeyframePoints read, in VINS-Mono's world.
nav_msgs::Odometry ToOdometry(const StampedPose& pose);
sensor_msgs::PointCloud ToKeyframePoints(std::int64_t stamp_ns,
                                         const std::vector<TrackedPoint>& points,
                                         const Camera& camera);

/// `/pose_graph/match_points`: points with x, y normalised in the old image and z the feature id,
/// by ascending id; the first channel has the old body's position, quaternion (w, x, y, z) and the
/// current keyframe's index. Ends with a point of an id that no track has: VINS-Mono looks for the
/// ids of its tracks one after the other, and passes the end when it has one above the last.
sensor_msgs::PointCloud ToMatchPoints(const Relocalisation& relocalisation,
                                      int current,
                                      std::int64_t stamp_current_ns,
                                      const std::string& frame_id);

/// What an image is decoded to.
enum class PixelKind {
  kGrey,   ///< CV_8UC1
  kColor,  ///< CV_8UC3 (blue, green, red) where the message has colours, otherwise CV_8UC1
};

/// Checks the header of an image (encoding mono8, 8UC1, rgb8, bgr8, rgba8, bgra8, mono16 or 16UC1,
/// sizes) now, and returns what decodes it later; 16 bits are divided by 256. Holds the message
/// alive. Unless `size` is empty, the image must be of it.
ImageSource FromImage(const sensor_msgs::ImageConstPtr& message,
                      const std::string& topic,
                      cv::Size size = {},
                      PixelKind kind = PixelKind::kGrey);

/// As FromImage for JPEG or PNG; the source throws InputError when the data can't be decoded.
ImageSource FromCompressedImage(const sensor_msgs::CompressedImageConstPtr& message,
                                const std::string& topic,
                                cv::Size size = {},
                                PixelKind kind = PixelKind::kGrey);

/// Grey or BGR image (CV_8UC1 or CV_8UC3) to mono8 or bgr8.
sensor_msgs::Image ToImage(const cv::Mat& image,
                           std::int64_t stamp_ns,
                           const std::string& frame_id);

}  // namespace deja_view
