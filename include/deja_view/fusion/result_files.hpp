#pragma once

#include "deja_view/fusion/loop_rows.hpp"
#include "deja_view/pipeline/loop_closer.hpp"

#include <filesystem>
#include <limits>
#include <vector>

namespace deja_view {

/// Adds what a keyframe told of loops to a flight's rows. A withdrawn loop becomes no row of its
/// own: the one that was accepted is no more.
void AddLoopRows(const std::vector<LoopReport>& told, LoopRows* rows);
void AddLoopRows(const std::vector<LoopReport>& told, std::vector<LoopReport>* rows);

/// All keyframes, a loaded map's too; of more than `most` that many, spread evenly, the newest
/// among them.
std::vector<KeyframeInfo> ListKeyframes(const LoopCloser& closer,
                                        int most = std::numeric_limits<int>::max());

/// Writes what a flight gave to `directory`, which is made when missing:
///   trajectory.txt  corrected body poses of the keyframes, TUM format
///   vio.txt         the same as the VIO gave them
///   places.txt      the keyframes that can be recognised, as trajectory.txt, a loaded map's too
///   loops.csv       one row per verified candidate, in the order of decision: stamp_current_ns,
///                   stamp_old_ns, tx, ty, tz, qx, qy, qz, qw (T_Bold_Bcurrent [m]), score,
///                   inliers, virtual, accepted, reason (`withdrawn`: it was accepted first)
///   matches.csv     the matched pixels of the given loops, a row each: stamp_current_ns,
///                   stamp_old_ns, virtual, view (of the old keyframe; -1: its real image), u_old,
///                   v_old, u_current, v_current [px]
/// Keyframes with an index below `first_own` (a loaded map's) are left out of the trajectories.
/// Throws InputError when a file can't be written.
void WriteResultFiles(const std::filesystem::path& directory,
                      const std::vector<KeyframeInfo>& keyframes,
                      int first_own,
                      const LoopRows& loops,
                      const std::vector<LoopMatches>& matches = {});

/// Makes the directory when it is missing. Throws InputError that names it unless files can be
/// written there.
void CheckWritable(const std::filesystem::path& directory);

}  // namespace deja_view
