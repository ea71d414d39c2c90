#include "deja_view/geometry/trajectory_alignment.hpp"
#include "deja_view/io/vins_config.hpp"
#include "deja_view/nerf/checkpoint.hpp"

#include "common/pose_input.hpp"
#include "nerf/nerf_command.hpp"

namespace deja_view {
namespace {

Trajectory OfCamera(const PoseSource& source, const Rigid3& T_B_C) {
  return source.is_of_camera ? source.trajectory : Transform(source.trajectory, T_B_C);
}

}  // namespace

nlohmann::ordered_json RunNerfAlign(const NerfAlignRequest& request) {
  nerf::RadianceField field = nerf::ReadField(request.model);
  const Rigid3 T_B_C = ReadVinsConfig(request.camera).T_B_C;
  const PoseSource source = ReadPoses(request.poses, request.poses_of == "camera");
  AlignmentOptions options;
  options.freedom = source.has_scale ? AlignmentFreedom::kRigid : AlignmentFreedom::kSimilarity;
  options.max_rmse_m = request.max_rmse_m;
  options.inlier_distance_m = 1.5 * request.max_rmse_m;
  const RobustAlignment fit = AlignTrajectories(OfCamera(ReadPoses(request.align_to, false), T_B_C),
                                                OfCamera(source, T_B_C),
                                                options,
                                                request.poses + ", against " + request.align_to);
  field.frame = {true, fit.A_B};
  nerf::WriteField(request.out, field);
  nlohmann::ordered_json json;
  json["model"] = request.out.string();
  json["alignment"] = ToJson(fit);
  return json;
}

}  // namespace deja_view
