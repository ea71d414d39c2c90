#include "places/places_run.hpp"

#include "deja_view/base/atomic_file.hpp"
#include "deja_view/base/check.hpp"
#include "deja_view/base/output_lock.hpp"
#include "deja_view/base/progress.hpp"
#include "deja_view/features/make_feature_extractor.hpp"
#include "deja_view/io/image_files.hpp"
#include "deja_view/io/vins_config.hpp"
#include "deja_view/lab/evaluation/place_truth.hpp"
#include "deja_view/lab/evaluation/threshold_sweep.hpp"

#include <optional>
#include <utility>

#include "common/interrupt.hpp"
#include "common/shared_files.hpp"
#include "common/tool_figures.hpp"
#include <fmt/format.h>
#include <opencv2/imgcodecs.hpp>

namespace deja_view {
namespace {

namespace fs = std::filesystem;
using Json = nlohmann::ordered_json;

cv::Mat ReadGrey(const fs::path& path, const cv::Size& expected) {
  cv::Mat image = cv::imread(path.string(), cv::IMREAD_GRAYSCALE);
  if (image.empty()) {
    ThrowInputError("{}: can't be decoded as an image", path.string());
  }
  if (!expected.empty() && image.size() != expected) {
    ThrowInputError("{}: {} x {} px, expected {} x {}",
                    path.string(),
                    image.cols,
                    image.rows,
                    expected.width,
                    expected.height);
  }
  return image;
}

FeatureOptions ToFeatureOptions(const PlacesRequest& request) {
  FeatureOptions options;
  options.kind = EnumFromString<FeatureKind>(request.features).value();
  options.orientation = PatchOrientation::kImage;
  options.brief.max_features = request.max_features;
  options.orb.max_features = request.max_features;
  options.orb.levels = request.levels;
  return options;
}

std::shared_ptr<const Vocabulary> OpenVocabulary(const PlacesRequest& request) {
  const fs::path path = request.vocabulary.empty()
                            ? FindSharedFile("vocabulary/" + request.features + ".dvv")
                            : request.vocabulary;
  auto vocabulary = Vocabulary::Open(path);
  if (vocabulary->descriptor_name() != request.features) {
    ThrowInputError("{}: of {} features, expected {}",
                    path.string(),
                    vocabulary->descriptor_name(),
                    request.features);
  }
  return vocabulary;
}

/// What is found, and the mean seconds of each step.
struct Found {
  std::vector<AppearanceMatch> matches;
  double read_s = 0;
  double features_s = 0;
  AppearanceTimes times;
};

Found FindPlaces(const std::vector<fs::path>& paths,
                 const PlacesRequest& request,
                 const AppearancePlacesOptions& options,
                 cv::Size size) {
  const Interrupt interrupt;
  const auto extractor = MakeFeatureExtractor(ToFeatureOptions(request));
  AppearancePlaces places(options, OpenVocabulary(request));
  std::optional<Progress> progress;
  if (request.show_progress) {
    progress.emplace("places", "images", paths.size());
  }
  Found found;
  for (const fs::path& path : paths) {
    interrupt.Check();
    const auto start = Clock::now();
    const cv::Mat image = ReadGrey(path, size);
    size = image.size();
    const double read_s = SecondsSince(start);
    Features features = extractor->Extract(image);
    found.read_s += read_s;
    found.features_s += SecondsSince(start) - read_s;
    AppearanceTimes times;
    found.matches.push_back(places.Add(std::move(features), &times));
    found.times.words += times.words;
    found.times.query += times.query;
    found.times.two_view += times.two_view;
    if (progress) {
      progress->Update(found.matches.size());
    }
  }
  if (progress) {
    progress->Finish(found.matches.size());
  }
  return found;
}

Json Milliseconds(const Found& found) {
  const double scale = 1e3 / static_cast<double>(found.matches.size());
  const AppearanceTimes& times = found.times;
  const double all_s = found.features_s + times.words + times.query + times.two_view;
  return {{"features", scale * found.features_s},
          {"words", scale * times.words},
          {"query", scale * times.query},
          {"two_view", scale * times.two_view},
          {"all", scale * all_s},
          {"reading", scale * found.read_s}};
}

std::vector<SweepPoint> Sweep(const Found& found, const PlaceTruth& truth) {
  std::vector<ScoredDecision> decisions;
  for (std::size_t i = 0; i < found.matches.size(); ++i) {
    const AppearanceMatch& match = found.matches[i];
    if (match.score > 0) {
      const bool is_right = IsTrueMatch(truth, static_cast<int>(i), match.id);
      decisions.push_back({match.score, is_right, !truth[i].empty()});
    }
  }
  return SweepThreshold(decisions, CountRevisits(truth));
}

void WritePairs(const fs::path& path,
                const std::vector<fs::path>& images,
                const Found& found,
                const std::optional<PlaceTruth>& truth) {
  WriteFileAtomically(path, [&](std::ostream& out) {
    out << "query,match,score,inliers,matches,similarity,right,query_image,match_image\n";
    for (std::size_t i = 0; i < images.size(); ++i) {
      const AppearanceMatch& match = found.matches[i];
      if (match.id < 0) {
        continue;
      }
      const bool is_right = truth && IsTrueMatch(*truth, static_cast<int>(i), match.id);
      out << fmt::format("{},{},{},{},{},{:.6f},{},{},{}\n",
                         i,
                         match.id,
                         match.score,
                         match.inliers,
                         match.matches,
                         match.similarity,
                         truth ? (is_right ? "1" : "0") : "",
                         images[i].filename().string(),
                         images[static_cast<std::size_t>(match.id)].filename().string());
    }
  });
}

void WriteCurve(const fs::path& path, const std::vector<SweepPoint>& sweep) {
  WriteFileAtomically(path, [&](std::ostream& out) {
    out << "score,found,correct,precision,recall\n";
    for (const SweepPoint& point : sweep) {
      out << fmt::format("{},{},{},{:.6f},{:.6f}\n",
                         point.r,
                         point.found,
                         point.correct,
                         point.precision,
                         point.recall);
    }
  });
}

}  // namespace

Json RunPlaces(const PlacesRequest& request) {
  AppearancePlacesOptions options = request.options;
  std::vector<std::string> violations = options.Validate();
  const std::vector<std::string> of_features = ToFeatureOptions(request).Validate();
  violations.insert(violations.end(), of_features.begin(), of_features.end());
  if (!violations.empty()) {
    ThrowInputError("places: {}", fmt::join(violations, "; "));
  }
  const std::vector<fs::path> paths = ListImages(request.images);
  std::optional<PlaceTruth> truth;
  if (!request.groundtruth.empty()) {
    truth = ReadPlaceTruth(request.groundtruth, paths.size());
  }
  std::shared_ptr<const Camera> camera;
  cv::Size size;
  if (!request.camera.empty()) {
    camera = ReadVinsConfig(request.camera).camera;
    options.two_view.camera = camera.get();
    size = cv::Size(camera->width(), camera->height());
  }
  std::optional<OutputLock> lock;
  if (!request.out.empty()) {
    lock.emplace(OutputLock::OfDirectory(request.out));
  }
  const Found found = FindPlaces(paths, request, options, size);
  if (!request.out.empty()) {
    WritePairs(request.out / "pairs.csv", paths, found, truth);
  }
  Json json = {{"images", paths.size()}, {"features", request.features}};
  json["two_view"] = camera ? "essential" : "fundamental";
  if (truth) {
    const std::vector<SweepPoint> sweep = Sweep(found, *truth);
    const SweepPoint sure = PickThreshold(sweep, 1.0);
    json["revisits"] = CountRevisits(*truth);
    json["recall_at_precision_1"] = sure.recall;
    json["score_at_precision_1"] = sure.recall > 0 ? Json(sure.r) : Json(nullptr);
    json["recall_of_all"] = sweep.empty() ? 0.0 : sweep.back().recall;
    json["precision_of_all"] = sweep.empty() ? Json(nullptr) : Json(sweep.back().precision);
    if (!request.out.empty()) {
      WriteCurve(request.out / "pr_curve.csv", sweep);
    }
  }
  json["ms_per_image"] = Milliseconds(found);
  return json;
}

}  // namespace deja_view
