#pragma once

#include "deja_view/features/feature_extractor.hpp"
#include "deja_view/features/feature_options.hpp"

#include <memory>

namespace deja_view {

/// The extractor that `options.kind` names. Throws CheckError for invalid options, InputError for a
/// bad pattern file.
std::unique_ptr<FeatureExtractor> MakeFeatureExtractor(const FeatureOptions& options);

}  // namespace deja_view
