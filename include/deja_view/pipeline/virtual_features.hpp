#pragma once

#include "deja_view/features/feature_extractor.hpp"
#include "deja_view/views/virtual_view.hpp"

namespace deja_view {

/// Features of a view's image, as its message carries them when they are made offline: keypoints
/// whose certainty is at least `min_certainty` (of 1; all where the view tells none), with the
/// depth of those that stand on no depth edge and no sigma. The view must have an image.
VirtualFeatures ExtractVirtualFeatures(const VirtualView& view,
                                       const FeatureExtractor& extractor,
                                       double min_certainty);

}  // namespace deja_view
