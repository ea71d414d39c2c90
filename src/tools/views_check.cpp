#include "deja_view/base/check.hpp"
#include "deja_view/base/progress.hpp"
#include "deja_view/features/make_feature_extractor.hpp"
#include "deja_view/views/view_matching.hpp"

#include <algorithm>
#include <map>
#include <optional>
#include <set>

#include "interrupt.hpp"
#include "tool_figures.hpp"
#include "views_command.hpp"
#include "views_input.hpp"
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

// Ways of making a view of full size with the radiance field.
std::map<std::string, ViewUpscaler> MakeWays(UpscalingOptions options,
                                             const std::filesystem::path& network) {
  std::map<std::string, ViewUpscaler> ways;
  const auto add = [&](const char* name, Upscaling method) {
    options.method = method;
    ways.emplace(name, ViewUpscaler(options));
  };
  add("nerf_direct", Upscaling::kDirect);
  add("nerf_bicubic", Upscaling::kBicubic);
  add("nerf_patches", Upscaling::kPatches);
  if (!network.empty()) {
    options.network = network;
  }
  try {
    add("nerf_fsrcnn", Upscaling::kFsrcnn);
  } catch (const InputError&) {
    // OpenCV may lack its dnn; only who names a network has to know.
    if (!network.empty()) {
      throw;
    }
  }
  return ways;
}

class Check {
 public:
  // `flown_N`: positions of the camera along the flight.
  Check(const ViewsCheckRequest& request,
        const PosedJob& posed,
        const std::vector<Eigen::Vector3d>& flown_N)
      : job_(posed.job),
        renderer_(ReadModel(request.input.model, posed.poses)),
        warp_(WarpFactory(job_.camera)),
        ways_(MakeWays(job_.options.rendering, request.network)),
        gate_(job_.options.gate, job_.camera, flown_N),
        extractor_(MakeFeatureExtractor(job_.options.features)) {}

  // At the virtual poses that the radiance field offers for this image.
  void Add(const LoadedSource& sample, const ViewSource& next) {
    const Features real = extractor_->Extract(sample.source.image);
    const cv::Mat depth =
        renderer_->Render(*job_.camera, sample.source.T_N_C, {1, 0, job_.threads}).depth;
    const ExposureFit fit = FitSourceExposure(*renderer_,
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
    const auto warp = warp_(sample.source, sample.points);
    const auto accept = [&](const Rigid3& T_C_V) {
      const GateVerdict verdict = gate_.Judge(*renderer_, sample.source.T_N_C, T_C_V);
      not_free_ += verdict == GateVerdict::kNotFree ? 1 : 0;
      uncertain_ += verdict == GateVerdict::kUncertain ? 1 : 0;
      return verdict == GateVerdict::kAccepted;
    };
    for (const Rigid3& T_C_V : SampleViews(job_.options.sampling, sample.source.stamp_ns, accept)) {
      const Rigid3 T_N_V = sample.source.T_N_C * T_C_V;
      const auto match = [&](const std::string& name,
                             const ViewUpscaler& way,
                             const ViewRenderer& from,
                             const ViewRenderOptions& options) {
        const auto start = Clock::now();
        const double cpu_s = CpuSeconds();
        const RenderedView view = way.Render(from, *job_.camera, T_N_V, options);
        const Cost cost{1e3 * SecondsSince(start),
                        1e3 * (CpuSeconds() - cpu_s),
                        JpegBytes(view.image, job_.options.jpeg_quality)};
        tallies_[name].Add(
            CountCorrectMatches(real, extractor_->Extract(view.image), depth, *job_.camera, T_C_V),
            cost);
      };
      for (const auto& [name, way] : ways_) {
        match(name, way, *renderer_, exposure);
      }
      match("warp", ways_.at("nerf_direct"), *warp, {1, 0, job_.threads});
    }
    tallies_["next_image"].Add(CountCorrectMatches(real,
                                                   extractor_->Extract(next.image),
                                                   depth,
                                                   *job_.camera,
                                                   sample.source.T_N_C.Inverse() * next.T_N_C),
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
    return json;
  }

 private:
  const ViewJob& job_;
  std::shared_ptr<const ViewRenderer> renderer_;
  ViewRendererFactory warp_;
  std::map<std::string, ViewUpscaler> ways_;
  ViewGate gate_;
  std::unique_ptr<FeatureExtractor> extractor_;
  std::map<std::string, Tally> tallies_;
  int not_recognised_ = 0;
  int not_free_ = 0;
  int uncertain_ = 0;
};

// Images spread over the flight, each with the one after it.
struct Pairs {
  std::vector<SourceImage> images;
  std::set<std::int64_t> first_stamps;
};

Pairs ChoosePairs(const std::vector<SourceImage>& all, int count) {
  Pairs pairs;
  const std::size_t step = std::max<std::size_t>(1, all.size() / static_cast<std::size_t>(count));
  for (std::size_t i = 0;
       i + 1 < all.size() && pairs.first_stamps.size() < static_cast<std::size_t>(count);
       i += step) {
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
  const BagReader bag(job.bag);
  const std::vector<SourceImage> images =
      FindSourceImages(bag, job.topics, job.sources, job.T_N_C).images;
  Check check(request, posed, Positions(images));
  std::optional<Progress> progress;
  if (request.input.show_progress) {
    progress.emplace("matching", "images", static_cast<std::size_t>(request.images));
  }
  const Pairs pairs = ChoosePairs(images, request.images);
  std::size_t done = 0;
  std::optional<LoadedSource> before;
  ReadSourceImages(
      bag, job.topics, *job.camera, job.T_B_C, pairs.images, [&](const LoadedSource& loaded) {
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
