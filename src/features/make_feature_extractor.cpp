#include "deja_view/features/make_feature_extractor.hpp"

#include "deja_view/features/brief_extractor.hpp"
#include "deja_view/features/orb_extractor.hpp"

namespace deja_view {

std::unique_ptr<FeatureExtractor> MakeFeatureExtractor(const FeatureOptions& options) {
  if (options.kind == FeatureKind::kOrb) {
    return std::make_unique<OrbExtractor>(options.orb);
  }
  return std::make_unique<BriefExtractor>(options.brief);
}

}  // namespace deja_view
