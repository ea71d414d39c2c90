#pragma once

#include "deja_view/base/enum_names.hpp"
#include "deja_view/views/seen_surface.hpp"
#include "deja_view/views/view_gate.hpp"
#include "deja_view/views/view_sampling.hpp"

#include <cstdint>
#include <functional>
#include <memory>
#include <string>
#include <vector>

namespace deja_view {

/// How poses of views are found.
enum class ChoiceKind {
  kSampling,  ///< as many for each image as `sampling` says, wherever the gate lets them be
  kNeed,      ///< of all images together, those from which the place is not recognised without them
};

template <>
inline constexpr auto kEnumNames<ChoiceKind> = EnumNames("sampling", "need");

/// Which of the poses that could be rendered are worth a view.
struct ChoiceOptions {
  ChoiceKind by = ChoiceKind::kSampling;
  int candidates = 48;         ///< poses per image, drawn as `sampling` says
  bool reversed = false;       ///< also each of them looking back
  double views_per_image = 4;  ///< on average at most
  double min_gain = 0.5;       ///< poses that a view must make recognised, in all
  double enough = 0.5;    ///< share of a pose's surface, by SameLook, that is recognised for sure
  double view_worth = 1;  ///< of a rendered view, where a photograph's is 1
  SameLookOptions look;

  /// Violations, one line each.
  std::vector<std::string> Validate() const;

  template <typename Visitor>
  void Visit(Visitor& v) {
    v("by", by);
    v("candidates", candidates);
    v("reversed", reversed);
    v("views_per_image", views_per_image);
    v("min_gain", min_gain);
    v("enough", enough);
    v("view_worth", view_worth);
    v("look", look);
  }
};

/// A real image that may get views.
struct PlacedImage {
  std::int64_t stamp_ns = 0;
  Rigid3 T_N_C;  ///< z of N points up
};

/// Poses T_C_V of one image's views, and what was passed over on the way.
struct ChosenViews {
  std::vector<Rigid3> T_C_V;
  int not_free = 0;
  int uncertain = 0;
};

/// Chooses poses of views where they are needed. Poses about all images are drawn that are free and
/// known to the renderer; each stands both for a camera that may come there and for a view that
/// could be had. How well a camera is recognised is the best SameLook with a photograph or a view
/// that was chosen, up to `enough`. Views are taken one by one, each the one that adds most to the
/// sum over all cameras, which is submodular, so that this is within 1 - 1/e of the best choice
/// (Nemhauser, Wolsey and Fisher 1978).
class ViewChooser {
 public:
  /// As ViewGate's. Throws CheckError for options that are not valid.
  ViewChooser(const ChoiceOptions& choice,
              const SamplingOptions& sampling,
              const GateOptions& gate,
              std::shared_ptr<const Camera> camera,
              std::vector<Eigen::Vector3d> flown_N);

  /// For each of the images, in their order. Deterministic on any number of threads;
  /// `on_progress(done, total)` is called by one thread at a time, and may throw to interrupt.
  std::vector<ChosenViews> Choose(
      const std::vector<PlacedImage>& images,
      const ViewRenderer& renderer,
      int threads,
      const std::function<void(std::size_t done, std::size_t total)>& on_progress) const;

 private:
  struct Around;  // of one image

  Around LookAround(const PlacedImage& image, const ViewRenderer& renderer) const;

  ChoiceOptions choice_;
  SamplingOptions sampling_;
  GateOptions gate_options_;
  ViewGate gate_;
};

}  // namespace deja_view
