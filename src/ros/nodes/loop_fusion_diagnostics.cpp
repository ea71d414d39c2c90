#include "deja_view/ros/nodes/loop_fusion_node.hpp"

#include <fmt/format.h>

#include <diagnostic_msgs/DiagnosticStatus.h>

namespace deja_view {
namespace {

void AddViews(const LoopFusionStatistics& now,
              diagnostic_updater::DiagnosticStatusWrapper& status) {
  status.add("virtual views received", now.views.received);
  status.add("virtual views kept", now.views.kept);
  status.add("virtual views waiting for their keyframe", now.views.waiting);
  status.add("virtual views dropped: duplicate", now.views.duplicates);
  status.add("virtual views dropped: refused", now.views.refused);
  status.add("virtual views dropped: no_keyframe", now.views.no_keyframe);
  status.add("virtual views dropped: no_place", now.views.no_place);
  status.add("virtual views dropped: uncertain", now.views.uncertain);
  status.add("virtual views dropped: disagrees", now.views.disagree);
  status.add("virtual views dropped: surpassed", now.views.surpassed);
  status.add("virtual views dropped: queue full", now.view_overflows);
  status.add("memory of virtual views [kB]", now.view_memory_bytes / 1024);
}

void AddDrops(const AssemblerCounts& counts, diagnostic_updater::DiagnosticStatusWrapper& status) {
  status.add("dropped: missing_image", counts.missing_image);
  status.add("dropped: missing_points", counts.missing_points);
  status.add("dropped: duplicate", counts.duplicates);
  status.add("dropped: stray_stamp", counts.stray_stamps);
  status.add("dropped: overflow", counts.overflows);
  status.add("dropped: unmatched", counts.unmatched);
  status.add("dropped: extrinsic_jump", counts.extrinsic_jumps);
}

}  // namespace

// Rates and warnings are about the time since the last diagnosis; counts are totals.
void LoopFusionNode::Diagnose(diagnostic_updater::DiagnosticStatusWrapper& status) {
  using diagnostic_msgs::DiagnosticStatus;
  const LoopFusionStatistics now = fusion_->statistics();
  const LoopFusionStatistics before = std::exchange(diagnosed_, now);
  const std::int64_t bad = errors_.bad_inputs();
  const std::int64_t new_bad = bad - std::exchange(diagnosed_bad_messages_, bad);
  const ros::WallTime time = ros::WallTime::now();
  const double elapsed_s = std::max(1e-3, (time - std::exchange(diagnosed_at_, time)).toSec());

  const auto overflows = [](const LoopFusionStatistics& s) {
    return s.queue_overflows + s.view_overflows + s.assembler.overflows;
  };
  const std::vector<std::string> silent = watch_->Silent(ros::SteadyTime::now().toSec());
  if (overflows(now) > overflows(before)) {
    status.summary(DiagnosticStatus::ERROR, "messages are dropped: a queue is full");
  } else if (!silent.empty()) {
    status.summary(DiagnosticStatus::WARN,
                   fmt::format("no messages on {}", fmt::join(silent, ", ")));
  } else if (now.assembler.restarts > before.assembler.restarts) {
    status.summary(DiagnosticStatus::WARN, "the VIO started anew: a new sequence");
  } else if (now.joins_taken_back > before.joins_taken_back) {
    status.summary(DiagnosticStatus::WARN,
                   "the flight was joined wrongly to another world: loops are withdrawn");
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
  status.add("restarts of the VIO", now.assembler.restarts);
  status.add("joins taken back", now.joins_taken_back);
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
  AddViews(now, status);
  status.add("bad messages", bad);
  status.add("keyframes refused", now.refused);
  AddDrops(now.assembler, status);
}

}  // namespace deja_view
