#pragma once

#include "deja_view/features/feature_extractor.hpp"
#include "deja_view/features/feature_options.hpp"
#include "deja_view/views/exposure_fit.hpp"
#include "deja_view/views/pose_frame.hpp"
#include "deja_view/views/view_choice.hpp"
#include "deja_view/views/view_gate.hpp"
#include "deja_view/views/view_sampling.hpp"
#include "deja_view/views/view_upscaling.hpp"
#include "deja_view/views/virtual_view.hpp"

#include <cstdint>
#include <memory>
#include <optional>
#include <string>
#include <vector>

namespace deja_view {

/// Exposure of a virtual view.
enum class ViewExposure {
  kSource,   ///< as the real image's, fitted on a small render of its own pose
  kNeutral,  ///< the scene's own
};

template <>
inline constexpr auto kEnumNames<ViewExposure> = EnumNames("source", "neutral");

/// All that decides which views an image gets, and what they look like: a preset in config/.
struct ViewOptions {
  PoseFitOptions poses;
  SourceOptions sources;
  SamplingOptions sampling;
  ChoiceOptions choice;
  GateOptions gate;
  UpscalingOptions rendering;
  bool own_image = false;  ///< as the first view the image itself, with the model's depth
  ViewExposure exposure = ViewExposure::kSource;
  double fit_scale = 0.25;       ///< size of the small render that is compared with the real image
  double min_correlation = 0.5;  ///< between the two; below it the model does not show that place
  ImageFormat image_format = ImageFormat::kJpeg;
  int jpeg_quality = 85;    ///< of the images; 54 kB for 752 x 480 px
  FeatureOptions features;  ///< of the features, where they are wanted

  /// Violations, one line each.
  std::vector<std::string> Validate() const;

  template <typename Visitor>
  void Visit(Visitor& v) {
    v("poses", poses);
    v("sources", sources);
    v("sampling", sampling);
    v("choice", choice);
    v("gate", gate);
    v("rendering", rendering);
    v("own_image", own_image);
    v("exposure", exposure);
    v("fit_scale", fit_scale);
    v("min_correlation", min_correlation);
    v("image_format", image_format);
    v("jpeg_quality", jpeg_quality);
    v("features", features);
  }
};

/// What a view shall carry.
struct ViewContent {
  bool image = true;
  bool features = false;
  bool depth = false;  ///< depth and certainty
};

/// A real image that gets views.
struct ViewSource {
  std::int64_t stamp_ns = 0;
  cv::Mat image;  ///< CV_8UC1, the camera's size
  Rigid3 T_N_C;   ///< z of N points up, as in a VIO's world, where views are to have features
  std::optional<ChosenViews> chosen = std::nullopt;  ///< by a ViewChooser; none: by sampling
};

/// Views of one image, and how they came about.
struct MadeViews {
  std::vector<VirtualView> views;
  ExposureFit fit;            ///< of the render at the real pose to the real image
  bool is_recognised = true;  ///< false: the fit is too bad, so there are no views
  int not_free = 0;           ///< poses that were passed over
  int uncertain = 0;
};

/// Makes the virtual views of real images. Deterministic; safe to call from several threads.
class ViewMaker {
 public:
  /// `flown_N`: positions of the camera along the flight. `settings_hash` goes to the views. Throws
  /// CheckError for options that are not valid, InputError for bad files that they name.
  ViewMaker(const ViewOptions& options,
            const ViewContent& content,
            std::shared_ptr<const Camera> camera,
            std::vector<Eigen::Vector3d> flown_N,
            std::uint64_t settings_hash);
  ~ViewMaker();

  /// Throws CheckError for an image of another type or size than the camera's.
  MadeViews Make(const ViewSource& source, const ViewRenderer& renderer, int threads) const;

 private:
  /// Where the source's views are.
  ChosenViews FindPoses(const ViewSource& source, const ViewRenderer& renderer) const;
  VirtualView MakeView(const RenderedView& rendered,
                       const Rigid3& T_N_C,
                       const Rigid3& T_C_V) const;

  ViewOptions options_;
  ViewContent content_;
  std::shared_ptr<const Camera> camera_;
  ViewGate gate_;
  ViewUpscaler upscaler_;
  std::unique_ptr<FeatureExtractor> extractor_;
  std::uint64_t settings_hash_;
};

/// Fits the exposure of a render at the real image's pose, both at `scale`.
ExposureFit FitSourceExposure(const ViewRenderer& renderer,
                              const Camera& camera,
                              const ViewSource& source,
                              double scale,
                              double min_opacity,
                              int threads);

}  // namespace deja_view
