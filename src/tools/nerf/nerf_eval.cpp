#include "deja_view/base/check.hpp"
#include "deja_view/base/progress.hpp"
#include "deja_view/nerf/checkpoint.hpp"
#include "deja_view/nerf/field_renderer.hpp"
#include "deja_view/nerf/posed_images.hpp"

#include <memory>
#include <optional>

#include "common/device_option.hpp"
#include "common/interrupt.hpp"
#include "common/tool_figures.hpp"
#include "nerf/nerf_command.hpp"
#include "nerf/nerf_evaluation.hpp"
#include "nerf/sub_maps.hpp"

namespace deja_view {

using Json = nlohmann::ordered_json;

Json RunNerfEval(const NerfEvalRequest& request) {
  const Interrupt interrupt;
  const nerf::FieldRenderer renderer(
      std::make_shared<nerf::RadianceField>(nerf::ReadField(request.model)),
      ChooseToolDevice(request.device),
      nerf::FindKernels(request.kernels));
  NerfEvaluation evaluation(
      renderer, MakeLoadOptions(request.input, request.threads), request.pictures);
  nerf::Split split = ReadNerfInput(request.input);
  if (split.held_out.empty()) {
    ThrowInputError("no image is held out: expected --holdout N as in the training");
  }
  const SceneCells& cells = renderer.field().cells;
  if (cells.IsCut()) {
    CheckShard(request.shard, cells, request.model.string());
  }
  KeepOwnImages(cells.IsCut() ? cells : CutScene(split, request.shard), &split);
  if (request.views > 0 && split.held_out.size() > static_cast<std::size_t>(request.views)) {
    split.held_out.resize(static_cast<std::size_t>(request.views));
    split.depth_checks.clear();
  }
  std::optional<Progress> progress;
  if (request.show_progress) {
    progress.emplace("rendering", "views", split.held_out.size() + split.depth_checks.size());
  }
  for (std::size_t i = 0; i < split.held_out.size(); ++i) {
    interrupt.Check();
    evaluation.Compare(split.held_out[i],
                       split.training.empty() ? nullptr : &split.training[split.next[i]]);
    if (progress) {
      progress->Update(evaluation.render_ms().size());
    }
  }
  for (const nerf::PosedImage& image : split.depth_checks) {
    interrupt.Check();
    evaluation.CompareDepthOnly(image);
    if (progress) {
      progress->Update(evaluation.render_ms().size());
    }
  }
  if (progress) {
    progress->Finish(evaluation.render_ms().size());
  }
  Json json;
  json["psnr_db"] = Mean(evaluation.psnr_db());
  json["ssim"] = Mean(evaluation.ssim());
  json["corner_match_rate"] = Mean(evaluation.corner_match_rate());
  json["corner_match_ceiling"] = evaluation.corner_match_ceiling().empty()
                                     ? Json(nullptr)
                                     : Json(Mean(evaluation.corner_match_ceiling()));
  json["views"] = evaluation.psnr_db().size();
  json["depth_rel_err_median"] =
      evaluation.depth_views() > 0 ? Json(Median(evaluation.depth_errors())) : Json(nullptr);
  json["depth_views"] = evaluation.depth_views();
  json["render_ms_median"] = Median(evaluation.render_ms());
  json["peak_rss_mb"] = PeakRssMb();
  return json;
}

}  // namespace deja_view
