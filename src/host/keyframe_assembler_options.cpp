#include "deja_view/base/requirements.hpp"
#include "deja_view/host/keyframe_assembler.hpp"

namespace deja_view {

std::vector<std::string> KeyframeAssemblerOptions::Validate() const {
  Requirements r;
  const auto is_duration = [](double seconds) { return seconds > 0 && seconds <= 3600; };
  r.That(image_memory_mb > 0, "image_memory_mb", image_memory_mb, "more than 0 MB");
  r.That(max_pending >= 1, "max_pending", max_pending, "at least 1");
  r.That(is_duration(timeout_s), "timeout_s", timeout_s, "0 to 3600 s");
  r.That(later_messages >= 1, "later_messages", later_messages, "at least 1");
  r.That(is_duration(sequence_gap_s), "sequence_gap_s", sequence_gap_s, "0 to 3600 s");
  return r.errors();
}

}  // namespace deja_view
