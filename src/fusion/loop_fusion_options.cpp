#include "deja_view/fusion/loop_fusion_options.hpp"

#include <fmt/format.h>

namespace deja_view {

std::vector<std::string> NodeOptions::Validate() const {
  std::vector<std::string> violations;
  const auto require = [&violations](bool holds, const char* key, auto value, const char* range) {
    if (!holds) {
      violations.push_back(fmt::format("{}: {}: expected {}", key, value, range));
    }
  };
  const auto is_rate = [](double hertz) { return hertz > 0 && hertz <= 1000; };
  require(queue_size >= 1, "queue_size", queue_size, "at least 1");
  require(virtual_queue_size >= 1, "virtual_queue_size", virtual_queue_size, "at least 1");
  require(drain_s >= 0 && drain_s <= 3600, "drain_s", drain_s, "0 to 3600 s");
  require(is_rate(path_rate_hz), "path_rate_hz", path_rate_hz, "above 0, up to 1000 Hz");
  require(is_rate(diagnostics_rate_hz),
          "diagnostics_rate_hz",
          diagnostics_rate_hz,
          "above 0, up to 1000 Hz");
  require(match_image_memory >= 0, "match_image_memory", match_image_memory, "0 or more");
  return violations;
}

std::vector<std::string> LoopFusionOptions::Validate() const {
  std::vector<std::string> violations = loop_closer.Validate();
  for (const std::string& violation : assembler.Validate()) {
    violations.push_back("assembler." + violation);
  }
  for (const std::string& violation : node.Validate()) {
    violations.push_back("node." + violation);
  }
  return violations;
}

}  // namespace deja_view
