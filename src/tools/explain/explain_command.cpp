#include "deja_view/base/atomic_file.hpp"
#include "deja_view/base/check.hpp"
#include "deja_view/base/output_lock.hpp"
#include "deja_view/lab/report/matches.hpp"
#include "deja_view/lab/report/svg.hpp"

#include <iostream>
#include <memory>
#include <set>
#include <string>
#include <vector>

#include "common/commands.hpp"
#include "common/reporting.hpp"
#include "explain/explanation.hpp"
#include "replay/replay.hpp"
#include "replay/replay_options.hpp"
#include "report/report_pictures.hpp"
#include <fmt/format.h>

namespace deja_view {
namespace {

namespace fs = std::filesystem;
using Json = nlohmann::ordered_json;

struct ExplainRequest {
  ReplayRequest replay;
  std::vector<std::string> pair;
  fs::path map_bag;  ///< of the loaded map, for its images
};

report::Point ToPoint(const Eigen::Vector2f& pixel) {
  return pixel.cast<double>();
}

report::MatchedLoop Empty(const PairExplanation& pair) {
  report::MatchedLoop loop;
  loop.stamp_current_ns = pair.stamp_current_ns;
  loop.stamp_old_ns = pair.stamp_old_ns;
  return loop;
}

report::MatchedLoop Inliers(const PairExplanation& pair) {
  const bool with_views = pair.with_views && !pair.with_views->pairs.empty();
  const PairExplanation::Attempt& attempt = with_views ? *pair.with_views : pair.real;
  report::MatchedLoop loop = Empty(pair);
  loop.is_virtual = with_views;
  for (const LoopMatches::Pair& match : attempt.pairs) {
    loop.pairs.push_back({match.view, ToPoint(match.old_pixel), ToPoint(match.current_pixel)});
  }
  return loop;
}

report::MatchedLoop FirstMatches(const PairExplanation& pair) {
  report::MatchedLoop loop = Empty(pair);
  loop.kind = "pair";
  for (const PixelMatch& match : pair.first_matches) {
    loop.pairs.push_back({-1, ToPoint(match.old_pixel), ToPoint(match.current_pixel)});
  }
  return loop;
}

void WritePage(const ExplainRequest& request,
               const PairExplanation& pair,
               const std::vector<std::string>& lines) {
  const report::MatchedLoop inliers = Inliers(pair);
  const report::MatchedLoop first = FirstMatches(pair);
  std::set<std::pair<std::int64_t, int>> wanted;
  for (const auto& key : report::PicturesOf(inliers)) {
    wanted.insert(key);
  }
  std::vector<fs::path> bags = {request.replay.bag};
  for (const fs::path& bag : {request.replay.virtual_bag, request.map_bag}) {
    if (!bag.empty()) {
      bags.push_back(bag);
    }
  }
  const VinsConfig vins = ReadVinsConfig(request.replay.camera);
  const report::Pictures pictures =
      ReadPictures(bags, request.replay.host.Topics(vins, request.replay.camera).image, wanted);
  std::string html =
      "<!DOCTYPE html>\n<html lang=\"en\"><head><meta charset=\"utf-8\"><title>Why</title>\n"
      "<style>body{font:15px/1.5 system-ui,sans-serif;max-width:1100px;margin:2em auto;padding:0 "
      "1em}svg{max-width:100%;height:auto}</style></head><body>\n<pre>";
  for (const std::string& line : lines) {
    html += report::EscapeXml(line) + "\n";
  }
  html += "</pre>\n";
  html += report::MatchFigure(inliers, pictures, std::string("Inliers of the best pose"));
  html += report::MatchFigure(first, pictures, std::string("First matches, before geometry"));
  html += "</body></html>\n";
  WriteFileAtomically(request.replay.out / "explanation.html",
                      [&](std::ostream& out) { out << html; });
}

Json Explain(ExplainRequest request) {
  if (request.replay.out.empty()) {
    ThrowInputError("--out: expected a directory");
  }
  const OutputLock lock = OutputLock::OfDirectory(request.replay.out);
  request.replay.pair =
      AskedPair{ParseStamp("--pair", request.pair[0]), ParseStamp("--pair", request.pair[1])};
  const ReplayResult result = RunReplay(request.replay);
  if (!result.explanation) {
    ThrowInputError(
        "--pair {} {}: no two keyframes of these stamps in {}, the second one before the first or "
        "a place of the loaded map (loops.csv and trajectory.txt name them)",
        request.pair[0],
        request.pair[1],
        request.replay.bag.string());
  }
  const RejectReason reason = FinalReason(*result.explanation, result.loops);
  const std::vector<std::string> lines = ExplanationLines(*result.explanation, reason);
  for (const std::string& line : lines) {
    std::cout << line << "\n";
  }
  WritePage(request, *result.explanation, lines);
  std::cout << "see " << (request.replay.out / "explanation.html").string() << "\n";
  return ToJson(*result.explanation, reason);
}

}  // namespace

void AddExplainCommand(CLI::App& app, Command* command) {
  auto request = std::make_shared<ExplainRequest>();
  auto json_file = std::make_shared<std::string>();
  CLI::App* sub = app.add_subcommand("explain", "Why two keyframes were joined by a loop or not");
  AddReplayInput(sub, &request->replay);
  sub->add_option("--pair",
                  request->pair,
                  "Stamps of the keyframe and of the old one, in seconds or nanoseconds, as in "
                  "loops.csv and trajectory.txt (to within 20 ms)")
      ->expected(2)
      ->required();
  sub->add_option("--map-bag", request->map_bag, "Bag of the loaded map, to show its images");
  sub->add_option(
         "--out", request->replay.out, "Directory for explanation.html and the run's files")
      ->required();
  sub->add_option("--json", *json_file, "File for the figures");
  AddQuietOption(sub, &request->replay.show_progress);
  sub->footer(
      "Plays the bag as replay does, and verifies the pair when its keyframe comes.\n"
      "Example:\n  deja_view explain --bag hall.bag --camera euroc.yaml --pair 1403636620.3 "
      "1403636580.9 --out why");
  sub->callback([=] {
    *command = [=] {
      WriteJson(*json_file, Explain(*request));
      return 0;
    };
  });
}

}  // namespace deja_view
