#include "deja_view/ros/loop_fusion_node.hpp"

#include <diagnostic_msgs/DiagnosticStatus.h>

namespace deja_view {

// Rates and warnings are about the time since the last diagnosis; counts are totals.
void LoopFusionNode::Diagnose(diagnostic_updater::DiagnosticStatusWrapper& status) {
  using diagnostic_msgs::DiagnosticStatus;
  const LoopFusionStatistics now = fusion_->statistics();
  const LoopFusionStatistics before = std::exchange(diagnosed_, now);
  const std::int64_t bad = bad_messages_;
  const std::int64_t new_bad = bad - std::exchange(diagnosed_bad_messages_, bad);
  const ros::WallTime time = ros::WallTime::now();
  const double elapsed_s = std::max(1e-3, (time - std::exchange(diagnosed_at_, time)).toSec());

  const std::int64_t overflows = now.queue_overflows + now.assembler.overflows;
  if (overflows > before.queue_overflows + before.assembler.overflows) {
    status.summary(DiagnosticStatus::ERROR, "messages are dropped: a queue is full");
  } else if (new_bad > 0 || now.refused > before.refused) {
    status.summary(DiagnosticStatus::WARN, "messages or keyframes can't be used");
  } else if (now.assembler.missing_image > before.assembler.missing_image ||
             now.assembler.missing_points > before.assembler.missing_points) {
    status.summary(DiagnosticStatus::WARN, "messages of a keyframe are missing");
  } else {
    status.summary(DiagnosticStatus::OK, "ok");
  }

  const auto rate = [elapsed_s](std::int64_t newer, std::int64_t older) {
    return static_cast<double>(newer - older) / elapsed_s;
  };
  status.add("images [Hz]", rate(now.assembler.images, before.assembler.images));
  status.add("keyframes received [Hz]", rate(now.assembler.poses, before.assembler.poses));
  status.add("keyframes processed [Hz]", rate(now.keyframes, before.keyframes));
  status.add("keyframes", now.keyframes);
  status.add("time per keyframe, mean [ms]", now.mean_ms);
  status.add("time per keyframe, largest [ms]", now.max_ms);
  status.add("queue", now.queue_length);
  status.add("queue, longest", now.queue_peak);
  status.add("queue, dropped", now.queue_overflows);
  for (const auto& [reason, count] : now.candidates) {
    status.add("candidates: " + reason, count);
  }
  status.add("relative poses taken over", now.relative_poses);
  status.add("relative poses ignored", now.relative_poses_ignored);
  status.add("bad messages", bad);
  status.add("keyframes refused", now.refused);
  status.add("dropped: missing_image", now.assembler.missing_image);
  status.add("dropped: missing_points", now.assembler.missing_points);
  status.add("dropped: duplicate", now.assembler.duplicates);
  status.add("dropped: stray_stamp", now.assembler.stray_stamps);
  status.add("dropped: overflow", now.assembler.overflows);
  status.add("dropped: unmatched", now.assembler.unmatched);
}

}  // namespace deja_view
