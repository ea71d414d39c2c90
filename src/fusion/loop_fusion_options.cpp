#include "deja_view/fusion/loop_fusion_options.hpp"

#include "deja_view/base/requirements.hpp"

namespace deja_view {

std::vector<std::string> NodeOptions::Validate() const {
  Requirements r;
  const auto is_rate = [](double hertz) { return hertz > 0 && hertz <= 1000; };
  r.That(queue_size >= 1, "queue_size", queue_size, "at least 1");
  r.That(virtual_queue_size >= 1, "virtual_queue_size", virtual_queue_size, "at least 1");
  r.That(queue_memory_mb > 0, "queue_memory_mb", queue_memory_mb, "more than 0 MB");
  r.That(drain_s >= 0 && drain_s <= 3600, "drain_s", drain_s, "0 to 3600 s");
  r.That(is_rate(path_rate_hz), "path_rate_hz", path_rate_hz, "above 0, up to 1000 Hz");
  r.That(path_poses >= 1, "path_poses", path_poses, "at least 1");
  r.That(is_rate(diagnostics_rate_hz),
         "diagnostics_rate_hz",
         diagnostics_rate_hz,
         "above 0, up to 1000 Hz");
  r.That(match_image_memory >= 0, "match_image_memory", match_image_memory, "0 or more");
  return r.errors();
}

std::vector<std::string> LoopFusionOptions::Validate() const {
  std::vector<std::string> violations = loop_closer.Validate();
  Requirements parts;
  parts.Group("assembler", assembler.Validate());
  parts.Group("front_end", front_end.Validate());
  parts.Group("node", node.Validate());
  violations.insert(violations.end(), parts.errors().begin(), parts.errors().end());
  return violations;
}

}  // namespace deja_view
