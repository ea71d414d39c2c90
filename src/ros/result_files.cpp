#include "deja_view/ros/result_files.hpp"

#include "deja_view/base/atomic_file.hpp"
#include "deja_view/io/tum.hpp"

#include <ostream>

#include <fmt/format.h>

namespace deja_view {
namespace {

void WriteLoops(std::ostream& out, const std::vector<LoopReport>& loops) {
  out << "stamp_current_ns,stamp_old_ns,tx,ty,tz,qx,qy,qz,qw,score,inliers,virtual,accepted,"
         "reason\n";
  for (const LoopReport& loop : loops) {
    const Rigid3& T = loop.T_Bold_Bcurrent;
    out << fmt::format(
        "{},{},{:.6f},{:.6f},{:.6f},{:.8f},{:.8f},{:.8f},{:.8f},{:.6f},{},{},{},{}\n",
        loop.stamp_current_ns,
        loop.stamp_old_ns,
        T.t.x(),
        T.t.y(),
        T.t.z(),
        T.q.x(),
        T.q.y(),
        T.q.z(),
        T.q.w(),
        loop.score,
        loop.inliers,
        loop.is_virtual ? 1 : 0,
        loop.accepted() ? 1 : 0,
        ToString(loop.reason));
  }
}

}  // namespace

void WriteResultFiles(const std::filesystem::path& directory,
                      const std::vector<KeyframeInfo>& keyframes,
                      int first_own,
                      const std::vector<LoopReport>& loops) {
  Trajectory corrected;
  Trajectory vio;
  for (const KeyframeInfo& keyframe : keyframes) {
    if (keyframe.index >= first_own) {
      corrected.stamps_ns.push_back(keyframe.stamp_ns);
      corrected.poses.push_back(keyframe.T_M_B);
      vio.stamps_ns.push_back(keyframe.stamp_ns);
      vio.poses.push_back(keyframe.T_W_B);
    }
  }
  WriteTum(directory / "trajectory.txt", corrected);
  WriteTum(directory / "vio.txt", vio);
  WriteFileAtomically(directory / "loops.csv",
                      [&loops](std::ostream& out) { WriteLoops(out, loops); });
}

}  // namespace deja_view
