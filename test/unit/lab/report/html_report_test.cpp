#include "deja_view/lab/report/html_report.hpp"

#include "deja_view/base/check.hpp"

#include <filesystem>
#include <fstream>

#include "count_of.hpp"
#include "example_run.hpp"
#include <gtest/gtest.h>

namespace deja_view::report {
namespace {

namespace fs = std::filesystem;

JudgedRun Judged(const std::string& name) {
  RunData run = ExampleRun();
  run.name = name;
  return Judge(std::move(run), ExampleGroundTruth(), Rigid3::Identity());
}

class TemporaryFile {
 public:
  TemporaryFile(const std::string& name, const std::string& content)
      : path_(fs::path(testing::TempDir()) / name) {
    std::ofstream(path_, std::ios::binary) << content;
  }
  ~TemporaryFile() { fs::remove(path_); }
  const fs::path& path() const { return path_; }

 private:
  fs::path path_;
};

HtmlReport FullReport() {
  HtmlReport report;
  report.runs = {Judged("plain"), Judged("with <views>")};
  report.sweeps = {{"threshold_sum", {{0.9, 1, 1, 1.0, 0.2}, {0.5, 5, 4, 0.8, 0.6}}, {}},
                   {"weights_text", {{0.9, 1, 1, 1.0, 0.2}}, {}}};
  report.sweeps[0].detections = {{ExampleStamp(5), ExampleStamp(1), {0.9, true, true}}};
  report.evaluation = nlohmann::ordered_json::parse(R"({"variants": [
      {"name": "spacing_2_no_virtual", "command": "deja_view replay --bag a", "recall": 0.5,
       "precision": 1.0, "cpu_s": 3.25, "map_recall": null},
      {"name": "spacing_2_virtual", "command": "deja_view replay --bag 'b c'", "recall": 0.75}]})");
  report.version = "1.2.3";
  report.command = "deja_view report --html x";
  return report;
}

TEST(HtmlReport, StandsAlone) {
  const std::string html = ToHtml(FullReport());
  EXPECT_EQ(html.rfind("<!DOCTYPE html>", 0), 0U);
  EXPECT_EQ(CountOf(html, "<style>"), 1U) << "figures share the page's";
  EXPECT_EQ(CountOf(html, "<script"), 0U);
  // No address is ever fetched: only namespaces and data.
  EXPECT_EQ(CountOf(html, "src=\""), CountOf(html, "src=\"data:"));
  EXPECT_EQ(CountOf(html, "href=\""), CountOf(html, "href=\"data:"));
  EXPECT_NE(html.find("prefers-color-scheme:dark"), std::string::npos);
  EXPECT_NE(html.find("name=\"viewport\""), std::string::npos);
}

TEST(HtmlReport, ShowsEveryPart) {
  const std::string html = ToHtml(FullReport());
  // Two trajectories, errors, statistics, loop counts, detections, two loop figures, scores,
  // two groups of sweeps and thresholds, spacing.
  EXPECT_EQ(CountOf(html, "<svg class=\"figure\""), 14U);
  EXPECT_EQ(CountOf(html, "<svg"), CountOf(html, "</svg>"));
  EXPECT_NE(html.find("with &lt;views&gt;"), std::string::npos);
  EXPECT_EQ(html.find("with <views>"), std::string::npos);
  EXPECT_NE(html.find("<td>3.25</td>"), std::string::npos);
  EXPECT_NE(html.find("deja_view replay --bag a"), std::string::npos);
  EXPECT_NE(html.find("1.2.3"), std::string::npos);
}

TEST(HtmlReport, RunsAloneAreEnough) {
  HtmlReport report;
  report.runs = {Judged("only")};
  const std::string html = ToHtml(report);
  EXPECT_EQ(html.find("<h2>Variants"), std::string::npos);
  EXPECT_EQ(CountOf(html, "<svg class=\"figure\""), 6U);
  report.runs.clear();
  EXPECT_THROW(ToHtml(report), CheckError);
}

TEST(HtmlReport, HoldsItsPictures) {
  HtmlReport report;
  report.runs = {Judged("only")};
  const TemporaryFile picture("deja_view_report.png", "\x89PNG\x01\x02");
  report.pictures = {{"a & b", picture.path()}};
  const std::string html = ToHtml(report);
  // 89 50 4e 47 01 02 in base 64.
  EXPECT_NE(html.find("data:image/png;base64,iVBORwEC\""), std::string::npos);
  EXPECT_NE(html.find("a &amp; b"), std::string::npos);
  const TemporaryFile text("deja_view_report.txt", "no picture");
  report.pictures = {{"text", text.path()}};
  EXPECT_THROW(ToHtml(report), InputError);
}

TEST(HtmlReport, CountsLoopsOverTime) {
  const std::string svg = LoopCountFigure({Judged("one")});
  EXPECT_NE(svg.find("one, 4"), std::string::npos) << "refused candidates are no loops";
}

TEST(HtmlReport, ShowsFurtherTablesAndMatches) {
  HtmlReport report;
  report.runs = {Judged("only")};
  report.tables = {{"Table <2>", {{"poses", "PSNR"}, {"colmap", "27.1"}}}};
  report.commands = {"roslaunch a b"};
  MatchedLoop loop;
  loop.stamp_current_ns = ExampleStamp(42);
  loop.stamp_old_ns = ExampleStamp(2);
  loop.pairs = {{-1, {1, 2}, {3, 4}}};
  report.matches = {{loop}};
  report.match_pictures[{loop.stamp_old_ns, -1}] = {"jpeg", 752, 480};
  const std::string html = ToHtml(report);
  EXPECT_NE(html.find("<h2>Table &lt;2&gt;</h2>"), std::string::npos);
  EXPECT_NE(html.find("<td>27.1</td>"), std::string::npos);
  EXPECT_NE(html.find("<code>roslaunch a b</code>"), std::string::npos);
  EXPECT_NE(html.find("<h2>Matched images</h2>"), std::string::npos);
  EXPECT_NE(html.find("At 21.0 s the place of 1.0 s is seen again"), std::string::npos);
  EXPECT_EQ(CountOf(html, "<image "), 1U);
  EXPECT_EQ(CountOf(html, "<style>"), 1U);
}

TEST(HtmlReport, ComparesDetectionsWithTheRunBefore) {
  JudgedRun fewer = Judged("fewer");
  fewer.run.loops.erase(fewer.run.loops.begin());
  fewer.ends.erase(fewer.ends.begin());
  const std::string svg = DetectionFigure({fewer, Judged("more")});
  EXPECT_NE(svg.find("fewer, 3"), std::string::npos);
  EXPECT_NE(svg.find("more, 4, 1 further"), std::string::npos);
}

TEST(HtmlReport, ErrorBarsNeedTruth) {
  EXPECT_NE(ApeFigure({Judged("one")}).find("median"), std::string::npos);
  EXPECT_TRUE(ApeFigure({Judge(ExampleRun(), {}, {})}).empty());
}

TEST(HtmlReport, SpacingFigureNeedsSpacings) {
  EXPECT_TRUE(SpacingFigure(nlohmann::ordered_json::parse(R"([{"name": "virtual"}])")).empty());
  const auto json = FullReport().evaluation;
  EXPECT_NE(SpacingFigure(json["variants"]).find("with virtual views"), std::string::npos);
}

}  // namespace
}  // namespace deja_view::report
