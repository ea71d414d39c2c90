// The options' YAML; after a first byte of 1, an override of the command line.
#include "deja_view/fusion/loop_fusion_options.hpp"
#include "deja_view/io/options_yaml.hpp"

#include "fuzz.hpp"

namespace deja_view::fuzz {

std::vector<std::string> Seeds() {
  return {
      '\0' + OptionsToYaml(LoopFusionOptions()),
      '\0' + std::string("node: {queue_size: 3, match_image: false}\nfeatures: {kind: orb}\n"),
      '\0' +
          std::string(
              "node: {queue_size: &q 3, virtual_queue_size: *q}\nassembler: {timeout_s: 2.5e0}\n"),
      '\1' + std::string("verification.pose.confidence=0.99"),
      '\1' + std::string("features.kind=orb"),
      '\1' + std::string("node.queue_size=7")};
}

void RunOne(const std::string& input) {
  const auto [prefix, text] = SplitPrefix(input);
  LoopFusionOptions options;
  if (prefix == 1) {
    OverrideOption(text, &options);
  } else {
    ParseOptions(text, "options.yaml", &options);
  }
}

}  // namespace deja_view::fuzz
