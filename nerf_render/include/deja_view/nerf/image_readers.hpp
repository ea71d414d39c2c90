#pragma once

#include "deja_view/camera/camera.hpp"
#include "deja_view/geometry/rigid3.hpp"
#include "deja_view/geometry/trajectory.hpp"
#include "deja_view/nerf/posed_images.hpp"

#include <cstdint>
#include <filesystem>
#include <memory>
#include <string>
#include <vector>

#include <Eigen/Core>

/// Posed images from the layouts in use. N is the world of the poses. All throw InputError that
/// names the file and what was expected: files that are missing or malformed, poses that are no
/// rigid transforms. Images without a pose, and poses without their image, are errors too, with
/// their count and first names, unless `skip_missing` leaves them out.
namespace deja_view::nerf {

/// Gives each image, by its stamp, the pose of a trajectory T_N_B, interpolated over at most 0.1 s;
/// T_B_C is the identity for a trajectory of the camera. `where` names the images in errors.
std::vector<PosedImage> AttachPoses(std::vector<PosedImage> images,
                                    const Rigid3& T_B_C,
                                    const Trajectory& T_N_B,
                                    bool skip_missing,
                                    const std::string& where);

/// Images named by their stamps (ListStampedImages), of a trajectory (AttachPoses).
std::vector<PosedImage> ReadTrajectoryImages(const std::filesystem::path& directory,
                                             std::shared_ptr<const Camera> camera,
                                             const Rigid3& T_B_C,
                                             const Trajectory& T_N_B,
                                             bool skip_missing = false);

/// A COLMAP model (ReadColmapModel) and its images, in `images` or, when that is empty, in `images`
/// beside the model or in a folder above it. Points seen by at least 3 images with an error of at
/// most 2 px become depth points; the unit of length is the model's own.
std::vector<PosedImage> ReadColmapImages(const std::filesystem::path& model,
                                         const std::filesystem::path& images,
                                         bool skip_missing = false);

/// instant-ngp's and nerfstudio's transforms.json: `w`, `h`, `fl_x`, `fl_y`, `cx`, `cy`, `k1`,
/// `k2`, `p1`, `p2` (with `camera_model` OPENCV_FISHEYE or `is_fisheye`: `k1` to `k4`) or
/// `camera_angle_x`, for all or per frame; `file_path`, which may lack its extension,
/// `transform_matrix`, and `depth_file_path` with `depth_unit_scale_factor` (0.001 [m]).
std::vector<PosedImage> ReadTransforms(const std::filesystem::path& file,
                                       bool skip_missing = false);

/// A folder of 7-Scenes: camera-intrinsics.txt (3 x 3), frame-XXXXXX.color.png or .jpg, .pose.txt
/// (4 x 4, camera to world) and, where it is there, .depth.png [mm]. Stamps are those of 30 frames
/// per second. The original data sets' intrinsics and poses are the depth sensor's: `color_camera`,
/// if given, took the images, from the same place.
std::vector<PosedImage> ReadSevenScenes(
    const std::filesystem::path& directory,
    bool skip_missing = false,
    const std::shared_ptr<const Camera>& color_camera = nullptr);

/// The depth maps of a folder, for images that `camera` took: 16-bit files named by the images'
/// stamps (ListStampedImages), of this camera, or a folder of 7-Scenes with its depth camera.
/// Images have a stamp, the camera and a depth map, nothing else.
std::vector<PosedImage> ListDepthMaps(const std::filesystem::path& directory,
                                      std::shared_ptr<const Camera> camera,
                                      double unit_m,
                                      bool is_along_ray);

/// A keyframe of a VIO: what it tracked and where it believes to have been.
struct VioKeyframe {
  std::int64_t stamp_ns = 0;
  Rigid3 T_W_C;
  std::vector<Eigen::Vector2d> pixels;
  std::vector<Eigen::Vector3d> p_W;  ///< [m], as many
};

/// Adds the points of keyframes to the images of the same stamp (within 1 us) as depth points: the
/// distance is that from the VIO's own pose. Points that project more than 3 px away from their
/// pixel are left out. Returns how many images got points.
std::size_t AddVioPoints(const std::vector<VioKeyframe>& keyframes,
                         std::vector<PosedImage>* images);

/// NeRFs' cameras look right-up-back, ours right-down-front: turns the axes of the camera, so that
/// T_N_C = FromRightUpBack(T_N_nerf). This is the only place that does.
Rigid3 FromRightUpBack(const Rigid3& T_N_nerf);

}  // namespace deja_view::nerf
