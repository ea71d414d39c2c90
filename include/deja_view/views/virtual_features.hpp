#pragma once

#include "deja_view/features/feature_extractor.hpp"
#include "deja_view/views/view_renderer.hpp"
#include "deja_view/views/virtual_view.hpp"

namespace deja_view {

/// Keypoints of a rendered view with their depth. Those whose pixel has less opacity than
/// `min_opacity` are left out: there is nothing that a camera would see.
///
/// The depth is that of the keypoint's pixel. Its variance is the render's own there plus that of
/// the depths in the 3 x 3 pixels around it: beside an edge in depth a corner may belong to either
/// side. `view.image` is CV_8UC1, `vertical` its field.
VirtualFeatures ExtractVirtualFeatures(const RenderedView& view,
                                       const FeatureExtractor& extractor,
                                       const VerticalField& vertical,
                                       double min_opacity);

/// The same of a view as its message carries it: keypoints whose certainty is at least
/// `min_certainty` (of 1; all where the view tells none), with the depth of those that stand on no
/// depth edge and no sigma. The view must have an image.
VirtualFeatures ExtractVirtualFeatures(const VirtualView& view,
                                       const FeatureExtractor& extractor,
                                       const VerticalField& vertical,
                                       double min_certainty);

}  // namespace deja_view
