#include "deja_view/fusion/result_files.hpp"

#include "deja_view/base/atomic_file.hpp"
#include "deja_view/base/check.hpp"
#include "deja_view/io/tum.hpp"

#include <algorithm>
#include <fstream>
#include <ostream>
#include <set>
#include <utility>

#include <fmt/format.h>

namespace deja_view {
namespace {

void WriteLoops(std::ostream& out, const LoopRows& loops) {
  out << "stamp_current_ns,stamp_old_ns,tx,ty,tz,qx,qy,qz,qw,score,inliers,virtual,accepted,"
         "reason\n";
  loops.ForEach([&out](const LoopRow& loop) {
    out << fmt::format("{},{},{:.6f},{:.8f},{:.6f},{},{},{},{}\n",
                       loop.stamp_current_ns,
                       loop.stamp_old_ns,
                       fmt::join(loop.t_Bold_Bcurrent, ","),
                       fmt::join(loop.q_Bold_Bcurrent, ","),
                       loop.score,
                       loop.inliers,
                       loop.is_virtual ? 1 : 0,
                       loop.accepted() ? 1 : 0,
                       EnumToString(loop.reason));
  });
}

/// Calls `add` for all that were not withdrawn, and returns (old, current) of those that were.
template <typename Add>
std::set<std::pair<int, int>> AddDecided(const std::vector<LoopReport>& told, const Add& add) {
  std::set<std::pair<int, int>> withdrawn;
  for (const LoopReport& loop : told) {
    if (loop.reason == RejectReason::kWithdrawn) {
      withdrawn.emplace(loop.old, loop.current);
    } else {
      add(loop);
    }
  }
  return withdrawn;
}

void WriteMatches(std::ostream& out, const std::vector<LoopMatches>& matches) {
  out << "stamp_current_ns,stamp_old_ns,virtual,view,u_old,v_old,u_current,v_current\n";
  for (const LoopMatches& loop : matches) {
    for (const LoopMatches::Pair& pair : loop.pairs) {
      out << fmt::format("{},{},{},{},{:.1f},{:.1f},{:.1f},{:.1f}\n",
                         loop.stamp_current_ns,
                         loop.stamp_old_ns,
                         loop.is_virtual ? 1 : 0,
                         pair.view,
                         pair.old_pixel.x(),
                         pair.old_pixel.y(),
                         pair.current_pixel.x(),
                         pair.current_pixel.y());
    }
  }
}

}  // namespace

void AddLoopRows(const std::vector<LoopReport>& told, LoopRows* rows) {
  rows->Withdraw(AddDecided(told, [rows](const LoopReport& loop) { rows->Add(loop); }));
}

void AddLoopRows(const std::vector<LoopReport>& told, std::vector<LoopReport>* rows) {
  std::set<std::pair<int, int>> withdrawn =
      AddDecided(told, [rows](const LoopReport& loop) { rows->push_back(loop); });
  MarkWithdrawn(rows, &withdrawn);
  DEJA_VIEW_CHECK(withdrawn.empty());
}

std::vector<KeyframeInfo> ListKeyframes(const LoopCloser& closer, int most) {
  std::vector<KeyframeInfo> keyframes;
  const int count = closer.keyframe_count();
  const int step = 1 + std::max(0, count - 1) / most;
  for (int i = std::max(0, count - 1) % step; i < count; i += step) {
    keyframes.push_back(closer.keyframe(i));
  }
  return keyframes;
}

void WriteResultFiles(const std::filesystem::path& directory,
                      const std::vector<KeyframeInfo>& keyframes,
                      int first_own,
                      const LoopRows& loops,
                      const std::vector<LoopMatches>& matches) {
  Trajectory corrected;
  Trajectory vio;
  Trajectory places;
  for (const KeyframeInfo& keyframe : keyframes) {
    if (keyframe.is_place) {
      places.stamps_ns.push_back(keyframe.stamp_ns);
      places.poses.push_back(keyframe.T_M_B);
    }
    if (keyframe.index >= first_own) {
      corrected.stamps_ns.push_back(keyframe.stamp_ns);
      corrected.poses.push_back(keyframe.T_M_B);
      vio.stamps_ns.push_back(keyframe.stamp_ns);
      vio.poses.push_back(keyframe.T_W_B);
    }
  }
  WriteTum(directory / "trajectory.txt", corrected);
  WriteTum(directory / "vio.txt", vio);
  WriteTum(directory / "places.txt", places);
  WriteFileAtomically(directory / "loops.csv",
                      [&loops](std::ostream& out) { WriteLoops(out, loops); });
  WriteFileAtomically(directory / "matches.csv",
                      [&matches](std::ostream& out) { WriteMatches(out, matches); });
}

void CheckWritable(const std::filesystem::path& directory) {
  std::error_code error;
  std::filesystem::create_directories(directory, error);
  const std::filesystem::path probe = directory / ".deja_view_probe";
  if (!std::ofstream(probe)) {
    ThrowInputError("{}: files can't be written there", directory.string());
  }
  std::filesystem::remove(probe, error);
}

}  // namespace deja_view
