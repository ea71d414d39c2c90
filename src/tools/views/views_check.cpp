#include "deja_view/base/check.hpp"
#include "deja_view/base/progress.hpp"
#include "deja_view/features/make_feature_extractor.hpp"
#include "deja_view/scene/open_scene_model.hpp"
#include "deja_view/views/view_matching.hpp"

#include <algorithm>
#include <cmath>
#include <functional>
#include <map>
#include <optional>
#include <set>
#include <utility>

#include "common/interrupt.hpp"
#include "common/tool_figures.hpp"
#include "views/views_command.hpp"
#include "views/views_input.hpp"
#include <opencv2/imgcodecs.hpp>

namespace deja_view {
namespace {

using Json = nlohmann::ordered_json;

// What one view took to make.
struct Cost {
  double ms = 0;
  double cpu_ms = 0;  // of all threads
  std::size_t bytes = 0;
};

// Sums over the views of one way of making them.
struct Tally {
  std::size_t views = 0;
  MatchCount matches;
  std::vector<double> render_ms;
  std::vector<double> render_cpu_ms;
  std::vector<double> bytes;

  void Add(const MatchCount& count, const Cost& cost) {
    ++views;
    matches.visible += count.visible;
    matches.matched += count.matched;
    matches.correct += count.correct;
    render_ms.push_back(cost.ms);
    render_cpu_ms.push_back(cost.cpu_ms);
    bytes.push_back(static_cast<double>(cost.bytes));
  }
};

Json ToJson(const Tally& tally) {
  const auto views = static_cast<double>(std::max<std::size_t>(1, tally.views));
  Json json;
  json["views"] = tally.views;
  json["visible"] = static_cast<double>(tally.matches.visible) / views;
  json["matched"] = static_cast<double>(tally.matches.matched) / views;
  json["correct"] = static_cast<double>(tally.matches.correct) / views;
  json["precision"] = static_cast<double>(tally.matches.correct) /
                      static_cast<double>(std::max<std::size_t>(1, tally.matches.matched));
  json["render_ms_median"] = Median(tally.render_ms);
  json["render_cpu_ms"] = Mean(tally.render_cpu_ms);
  json["bytes"] = Mean(tally.bytes);
  return json;
}

std::size_t JpegBytes(const cv::Mat& image, int quality) {
  std::vector<std::uint8_t> bytes;
  cv::imencode(".jpg", image, bytes, {cv::IMWRITE_JPEG_QUALITY, quality});
  return bytes.size();
}

// The least gate.max_depth_sigma with which the gate still offers a view; nothing when none does.
std::optional<double> LeastDepthSigma(const RenderedView& small, const GateOptions& options) {
  std::vector<double> sigmas;
  for (int y = 0; y < small.depth.rows; ++y) {
    for (int x = 0; x < small.depth.cols; ++x) {
      const auto depth = static_cast<double>(small.depth.at<float>(y, x));
      if (depth > 0 && small.opacity.at<float>(y, x) >= static_cast<float>(options.min_opacity)) {
        const auto variance = static_cast<double>(small.depth_variance.at<float>(y, x));
        sigmas.push_back(std::sqrt(variance) / depth);
      }
    }
  }
  const auto needed = static_cast<std::size_t>(
      std::ceil(options.min_certain_share * static_cast<double>(small.depth.total())));
  if (needed > sigmas.size()) {
    return std::nullopt;
  }
  const auto last =
      sigmas.begin() + static_cast<std::ptrdiff_t>(std::max<std::size_t>(1, needed) - 1);
  std::nth_element(sigmas.begin(), last, sigmas.end());
  return *last;
}

// Ways of making a view of full size with the radiance field.
std::map<std::string, ViewUpscaler> MakeWays(UpscalingOptions options,
                                             const ViewsCheckRequest& request) {
  std::map<std::string, ViewUpscaler> ways;
  const auto add = [&](const char* name, Upscaling method) {
    const auto& wanted = request.ways;
    if (wanted.empty() || std::find(wanted.begin(), wanted.end(), name) != wanted.end()) {
      options.method = method;
      ways.emplace(std::string("nerf_") + name, ViewUpscaler(options));
    }
  };
  add("direct", Upscaling::kDirect);
  add("bicubic", Upscaling::kBicubic);
  add("patches", Upscaling::kPatches);
  if (!request.network.empty()) {
    options.network = request.network;
  }
  try {
    add("fsrcnn", Upscaling::kFsrcnn);
  } catch (const InputError&) {
    // OpenCV may lack its dnn; only who asks for it has to know.
    if (!request.network.empty() || !request.ways.empty()) {
      throw;
    }
  }
  return ways;
}

// The images of a flight as their own model.
ViewRendererFactory OpenWarp(const ViewJob& job, const std::shared_ptr<const DepthMaps>& maps) {
  return RenderersInWorld(OpenSceneModel({"warp", {}, job.camera, maps, {}}), {});
}

class Check {
 public:
  // `flown_N`: positions of the camera along the flight.
  Check(const ViewsCheckRequest& request,
        const ViewJob& job,
        ViewRendererFactory renderers,
        const std::shared_ptr<const DepthMaps>& maps,
        const std::vector<Eigen::Vector3d>& flown_N)
      : job_(job),
        renderers_(std::move(renderers)),
        warp_(OpenWarp(job, nullptr)),
        depth_warp_(maps ? OpenWarp(job, maps) : nullptr),
        ways_(MakeWays(job_.options.rendering, request)),
        small_camera_(job_.camera->Scaled(job_.options.gate.scale)),
        gate_(job_.options.gate, job_.camera, flown_N),
        extractor_(MakeFeatureExtractor(job_.options.features)) {}

  // At the virtual poses that the radiance field offers for this image.
  void Add(const LoadedSource& sample, const ViewSource& next) {
    const auto renderer = renderers_(sample.source, sample.points);
    const Features real = extractor_->Extract(sample.source.image);
    const cv::Mat depth =
        renderer->Render(*job_.camera, sample.source.T_N_C, {1, 0, job_.threads}).depth;
    const ExposureFit fit = FitSourceExposure(*renderer,
                                              *job_.camera,
                                              sample.source,
                                              job_.options.fit_scale,
                                              job_.options.gate.min_opacity,
                                              job_.threads);
    if (fit.correlation < job_.options.min_correlation) {
      ++not_recognised_;
      return;
    }
    const ViewRenderOptions exposure{
        static_cast<float>(fit.gain), static_cast<float>(fit.bias), job_.threads};
    const auto warp = sample.points.empty() ? nullptr : warp_(sample.source, sample.points);
    const auto depth_warp = depth_warp_ ? depth_warp_(sample.source, {}) : nullptr;
    const auto accept = [&](const Rigid3& T_C_V) {
      const GateVerdict verdict = gate_.Judge(*renderer, sample.source.T_N_C, T_C_V);
      not_free_ += verdict == GateVerdict::kNotFree ? 1 : 0;
      uncertain_ += verdict == GateVerdict::kUncertain ? 1 : 0;
      return verdict == GateVerdict::kAccepted;
    };
    for (const Rigid3& T_C_V : SampleViews(job_.options.sampling, sample.source.stamp_ns, accept)) {
      Json offer;
      offer["stamp_ns"] = sample.source.stamp_ns;
      const Rigid3 T_N_V = sample.source.T_N_C * T_C_V;
      const std::optional<double> sigma = LeastDepthSigma(
          renderer->Render(*small_camera_, T_N_V, {1, 0, job_.threads}), job_.options.gate);
      offer["least_depth_sigma"] = sigma ? Json(*sigma) : Json(nullptr);
      for (const auto& [name, way] : ways_) {
        offer[name] = Match(name, way, *renderer, exposure, {real, depth, T_N_V, T_C_V});
      }
      if (warp != nullptr) {
        offer["warp"] =
            Match("warp", direct_, *warp, {1, 0, job_.threads}, {real, depth, T_N_V, T_C_V});
      }
      if (depth_warp != nullptr) {
        offer["warp_depth"] = Match(
            "warp_depth", direct_, *depth_warp, {1, 0, job_.threads}, {real, depth, T_N_V, T_C_V});
      }
      offers_.push_back(offer);
    }
    const Rigid3 T_C_next = sample.source.T_N_C.Inverse() * next.T_N_C;
    tallies_["next_image"].Add(
        CountCorrectMatches(real, extractor_->Extract(next.image), depth, *job_.camera, T_C_next),
        {0, 0, JpegBytes(next.image, job_.options.jpeg_quality)});
  }

  Json Report() const {
    Json json;
    for (const auto& [name, tally] : tallies_) {
      json[name] = ToJson(tally);
    }
    json["not_recognised"] = not_recognised_;
    json["not_free"] = not_free_;
    json["uncertain"] = uncertain_;
    json["offers"] = offers_;
    return json;
  }

 private:
  // What a view is compared with, and where it is.
  struct Place {
    const Features& real;
    const cv::Mat& depth;
    Rigid3 T_N_V;
    Rigid3 T_C_V;
  };

  // Renders and matches a view; returns its correct matches.
  std::size_t Match(const std::string& name,
                    const ViewUpscaler& way,
                    const ViewRenderer& from,
                    const ViewRenderOptions& options,
                    const Place& place) {
    const auto start = Clock::now();
    const double cpu_s = CpuSeconds();
    const RenderedView view = way.Render(from, *job_.camera, place.T_N_V, options);
    const Cost cost{1e3 * SecondsSince(start),
                    1e3 * (CpuSeconds() - cpu_s),
                    JpegBytes(view.image, job_.options.jpeg_quality)};
    const MatchCount count = CountCorrectMatches(
        place.real, extractor_->Extract(view.image), place.depth, *job_.camera, place.T_C_V);
    tallies_[name].Add(count, cost);
    return count.correct;
  }

  const ViewJob& job_;
  ViewRendererFactory renderers_;
  ViewRendererFactory warp_;
  ViewRendererFactory depth_warp_;  // null without depth maps
  std::map<std::string, ViewUpscaler> ways_;
  ViewUpscaler direct_{UpscalingOptions()};
  std::unique_ptr<Camera> small_camera_;
  ViewGate gate_;
  std::unique_ptr<FeatureExtractor> extractor_;
  std::map<std::string, Tally> tallies_;
  Json offers_ = Json::array();
  int not_recognised_ = 0;
  int not_free_ = 0;
  int uncertain_ = 0;
};

// Images spread over the flight, each with the one after it.
struct Pairs {
  std::vector<SourceImage> images;
  std::set<std::int64_t> first_stamps;
};

// Pairs whose first image `can_be_first`.
Pairs ChoosePairs(const std::vector<SourceImage>& all,
                  int count,
                  const std::function<bool(const SourceImage&)>& can_be_first) {
  std::vector<std::size_t> candidates;
  for (std::size_t i = 0; i + 1 < all.size(); ++i) {
    if (can_be_first(all[i])) {
      candidates.push_back(i);
    }
  }
  Pairs pairs;
  const std::size_t step =
      std::max<std::size_t>(1, candidates.size() / static_cast<std::size_t>(count));
  for (std::size_t c = 0;
       c < candidates.size() && pairs.first_stamps.size() < static_cast<std::size_t>(count);
       c += step) {
    const std::size_t i = candidates[c];
    pairs.first_stamps.insert(all[i].stamp_ns);
    pairs.images.push_back(all[i]);
    pairs.images.push_back(all[i + 1]);
  }
  return pairs;
}

std::vector<Eigen::Vector3d> Positions(const std::vector<SourceImage>& images) {
  std::vector<Eigen::Vector3d> positions;
  for (const SourceImage& image : images) {
    positions.push_back(image.T_N_C.t);
  }
  return positions;
}

}  // namespace

Json RunViewsCheck(const ViewsCheckRequest& request) {
  const Interrupt interrupt;
  const PosedJob posed = ReadViewsInput(request.input);
  const ViewJob& job = posed.job;
  const std::vector<SourceImage> images =
      FindSourceImages(*job.flight, job.topics, job.sources, job.T_N_C).images;
  const ViewModel model = PlaceModel(OpenSceneModel(request.input.model), posed);
  const auto maps = OpenFlightMaps(request.input.depth_maps, job);
  Check check(request, job, model.renderers, maps, Positions(images));
  std::optional<Progress> progress;
  if (request.input.show_progress) {
    progress.emplace("matching", "images", static_cast<std::size_t>(request.count));
  }
  const Pairs pairs = ChoosePairs(images, request.count, [&](const SourceImage& image) {
    return (model.sub_map.shard.count == 1 || model.sub_map.is_own(image.T_N_C.t)) &&
           (maps == nullptr || maps->Has(image.stamp_ns));
  });
  std::size_t done = 0;
  std::optional<LoadedSource> before;
  ReadSourceImages(*job.flight,
                   job.topics,
                   *job.camera,
                   job.T_B_C,
                   pairs.images,
                   [&](const LoadedSource& loaded) {
                     interrupt.Check();
                     if (before && pairs.first_stamps.count(before->source.stamp_ns) > 0) {
                       check.Add(*before, loaded.source);
                       if (progress) {
                         progress->Update(++done);
                       }
                     }
                     before = loaded;
                   });
  if (progress) {
    progress->Finish(done);
  }
  Json json = check.Report();
  json["alignment"] = ToJson(posed.poses);
  json["images"] = pairs.first_stamps.size();
  return json;
}

}  // namespace deja_view
