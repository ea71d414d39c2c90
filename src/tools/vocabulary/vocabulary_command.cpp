#include "vocabulary/vocabulary_command.hpp"

#include "deja_view/base/check.hpp"
#include "deja_view/base/parallel.hpp"
#include "deja_view/base/progress.hpp"
#include "deja_view/features/make_feature_extractor.hpp"
#include "deja_view/io/image_files.hpp"
#include "deja_view/vocabulary/vocabulary.hpp"
#include "deja_view/vocabulary/vocabulary_files.hpp"

#include <algorithm>
#include <chrono>
#include <iostream>
#include <memory>
#include <optional>

#include "common/commands.hpp"
#include "common/reporting.hpp"
#include "common/tool_figures.hpp"
#include <fmt/format.h>
#include <opencv2/imgcodecs.hpp>

namespace deja_view {
namespace {

namespace fs = std::filesystem;
using Json = nlohmann::ordered_json;

std::vector<fs::path> FindImages(const std::vector<fs::path>& directories) {
  std::vector<fs::path> paths;
  for (const fs::path& directory : directories) {
    const std::vector<fs::path> here = ListImages(directory);
    paths.insert(paths.end(), here.begin(), here.end());
  }
  return paths;
}

std::vector<std::vector<Descriptor>> ExtractAll(const std::vector<fs::path>& paths,
                                                const VocabularyTrainRequest& request) {
  FeatureOptions options;
  options.kind = EnumFromString<FeatureKind>(request.options.descriptor_name).value();
  const std::unique_ptr<FeatureExtractor> extractor = MakeFeatureExtractor(options);
  std::vector<std::vector<Descriptor>> images(paths.size());
  std::optional<Progress> progress;
  if (request.show_progress) {
    progress.emplace("features", "images", paths.size());
  }
  // In batches, so that progress is drawn by this thread.
  constexpr std::size_t kBatch = 64;
  for (std::size_t begin = 0; begin < paths.size(); begin += kBatch) {
    const std::size_t size = std::min(kBatch, paths.size() - begin);
    ParallelFor(request.options.threads, size, [&](std::size_t first, std::size_t last) {
      for (std::size_t i = begin + first; i < begin + last; ++i) {
        const cv::Mat image = cv::imread(paths[i].string(), cv::IMREAD_GRAYSCALE);
        if (image.empty()) {
          ThrowInputError("{}: can't be decoded as an image", paths[i].string());
        }
        images[i] = extractor->Extract(image).descriptors;
      }
    });
    if (progress) {
      progress->Update(begin + size);
    }
  }
  if (progress) {
    progress->Finish(paths.size());
  }
  return images;
}

const char* FormatName(const fs::path& path) {
  switch (DetectVocabularyFormat(path)) {
    case VocabularyFormat::kFlat:
      return "flat";
    case VocabularyFormat::kVins:
      return "vins_mono";
    case VocabularyFormat::kOrbSlam:
      return "orb_slam";
  }
  return "?";
}

std::string Hex(std::uint64_t value) {
  return fmt::format("{:016x}", value);
}

void Print(const Json& json) {
  for (const auto& [key, value] : json.items()) {
    std::cout << fmt::format(
        "{:<12} {}\n", key, value.is_string() ? value.get<std::string>() : value.dump());
  }
}

}  // namespace

Json RunVocabularyTrain(const VocabularyTrainRequest& request) {
  const std::vector<std::string> violations = request.options.Validate();
  if (!violations.empty()) {
    ThrowInputError("vocabulary train: {}", fmt::join(violations, "; "));
  }
  CheckVocabularyExtension(request.out);
  const auto start = Clock::now();
  const std::vector<fs::path> paths = FindImages(request.images);
  const std::vector<std::vector<Descriptor>> images = ExtractAll(paths, request);
  const double features_s = SecondsSince(start);
  std::size_t descriptors = 0;
  for (const auto& image : images) {
    descriptors += image.size();
  }

  const auto train_start = Clock::now();
  std::optional<Progress> progress;
  if (request.show_progress) {
    progress.emplace("training", "nodes", 0);
  }
  std::size_t nodes_done = 0;
  const VocabularyTree tree =
      TrainVocabulary(images, request.options, [&](std::size_t done, std::size_t total) {
        nodes_done = done;
        if (progress) {
          progress->Update(done, fmt::format("of {} so far", total));
        }
      });
  if (progress) {
    progress->Finish(nodes_done);
  }
  WriteVocabulary(request.out, tree);
  const auto vocabulary = Vocabulary::FromTree(tree);
  return {{"images", paths.size()},
          {"descriptors", descriptors},
          {"words", vocabulary->word_count()},
          {"nodes", vocabulary->node_count()},
          {"k", vocabulary->k()},
          {"levels", vocabulary->levels()},
          {"descriptor", vocabulary->descriptor_name()},
          {"bytes", fs::file_size(request.out)},
          {"features_s", features_s},
          {"train_s", SecondsSince(train_start)},
          {"identity", Hex(vocabulary->identity())}};
}

Json RunVocabularyConvert(const fs::path& in, const fs::path& out) {
  CheckVocabularyExtension(out);
  if (DetectVocabularyFormat(in) == VocabularyFormat::kFlat) {
    VerifyFlatVocabulary(in);
  }
  WriteVocabulary(out, Vocabulary::Open(in)->ToTree());
  return RunVocabularyInfo(out);
}

Json RunVocabularyInfo(const fs::path& path) {
  if (DetectVocabularyFormat(path) == VocabularyFormat::kFlat) {
    VerifyFlatVocabulary(path);
  }
  const auto vocabulary = Vocabulary::Open(path);
  double sum = 0;
  float min = vocabulary->Idf(0);
  float max = min;
  for (std::size_t word = 0; word < vocabulary->word_count(); ++word) {
    const float idf = vocabulary->Idf(static_cast<WordId>(word));
    sum += double{idf};
    min = std::min(min, idf);
    max = std::max(max, idf);
  }
  return {{"path", path.string()},
          {"format", FormatName(path)},
          {"descriptor", vocabulary->descriptor_name()},
          {"k", vocabulary->k()},
          {"levels", vocabulary->levels()},
          {"words", vocabulary->word_count()},
          {"nodes", vocabulary->node_count()},
          {"bytes", fs::file_size(path)},
          {"idf_min", min},
          {"idf_mean", sum / static_cast<double>(vocabulary->word_count())},
          {"idf_max", max},
          {"identity", Hex(vocabulary->identity())}};
}

namespace {

void AddTrain(CLI::App& vocabulary, Command* command) {
  auto request = std::make_shared<VocabularyTrainRequest>();
  auto json_file = std::make_shared<std::string>();
  CLI::App* sub = vocabulary.add_subcommand("train", "Train a vocabulary from images");
  sub->add_option("--images", request->images, "Directories of images")->required();
  sub->add_option("--out", request->out, "Vocabulary: .dvv (ours), .bin or .txt")->required();
  TrainOptions& options = request->options;
  sub->add_option("--descriptor", options.descriptor_name, "brief or orb")->capture_default_str();
  sub->add_option("--k", options.k, "Children of a node")->capture_default_str();
  sub->add_option("--levels", options.levels, "Depth of the tree, at most")->capture_default_str();
  sub->add_option("--max-words", options.max_words, "Split the fullest nodes first; 0: no limit")
      ->capture_default_str();
  sub->add_option("--iterations", options.iterations, "Of k-means at each node, at most")
      ->capture_default_str();
  sub->add_option("--seed", options.seed, "Of the random numbers")->capture_default_str();
  sub->add_option("--threads", options.threads, "0: all cores")->capture_default_str();
  sub->add_option("--json", *json_file, "File for the results");
  sub->footer("Example:\n  deja_view vocabulary train --images photos --levels 5 --out brief.dvv");
  sub->callback([=] {
    *command = [=] {
      const Json json = RunVocabularyTrain(*request);
      Print(json);
      WriteJson(*json_file, json);
      return 0;
    };
  });
}

void AddConvert(CLI::App& vocabulary, Command* command) {
  auto paths = std::make_shared<std::pair<std::string, std::string>>();
  CLI::App* sub = vocabulary.add_subcommand(
      "convert", "Convert between .dvv (ours), .bin (VINS-Mono) and .txt (ORB-SLAM)");
  sub->add_option("in", paths->first, "Vocabulary of any format")->required();
  sub->add_option("out", paths->second, "Format by extension")->required();
  sub->footer("Example:\n  deja_view vocabulary convert brief_k10L6.bin brief.dvv");
  sub->callback([=] {
    *command = [=] {
      Print(RunVocabularyConvert(paths->first, paths->second));
      return 0;
    };
  });
}

void AddInfo(CLI::App& vocabulary, Command* command) {
  auto path = std::make_shared<std::string>();
  auto json_file = std::make_shared<std::string>();
  CLI::App* sub = vocabulary.add_subcommand("info", "Check a vocabulary and tell what it holds");
  sub->add_option("file", *path, "Vocabulary of any format")->required();
  sub->add_option("--json", *json_file, "File for the results");
  sub->callback([=] {
    *command = [=] {
      const Json json = RunVocabularyInfo(*path);
      Print(json);
      WriteJson(*json_file, json);
      return 0;
    };
  });
}

}  // namespace

void AddVocabularyCommand(CLI::App& app, Command* command) {
  CLI::App* sub = app.add_subcommand("vocabulary", "Train, convert and inspect vocabularies");
  sub->require_subcommand(1);
  AddTrain(*sub, command);
  AddConvert(*sub, command);
  AddInfo(*sub, command);
}

}  // namespace deja_view
