#include "map/map_page.hpp"

#include "deja_view/base/atomic_file.hpp"

#include <algorithm>

#include <fmt/format.h>

namespace deja_view {
namespace {

namespace fs = std::filesystem;
using Json = nlohmann::ordered_json;

constexpr const char* kStyle = R"(
body { font: 15px/1.5 system-ui, sans-serif; color: #1f2328; background: #fff; max-width: 62em; margin: 2em auto;
  padding: 0 1em; }
h1, h2 { font-weight: 600; }
table { border-collapse: collapse; }
td { padding: .2em 1.2em .2em 0; vertical-align: top; }
td:last-child { color: #59636e; }
.advice li { border-left: 3px solid #d9580b; list-style: none; margin: .5em 0; padding-left: .8em; }
.advice { padding: 0; }
img { max-width: 100%; display: block; margin: .6em 0 .2em; }
figure { margin: 0 0 1.2em; }
figcaption { color: #59636e; }
@media (prefers-color-scheme: dark) {
  body { color: #e6edf3; background: #0d1117; }
  td:last-child, figcaption { color: #9198a1; }
}
)";

double Number(const Json& stage, const char* key) {
  return stage.contains(key) && stage[key].is_number() ? stage[key].get<double>() : 0.0;
}

std::string Row(const std::string& what, const std::string& value, const std::string& meaning) {
  return fmt::format("<tr><td>{}</td><td>{}</td><td>{}</td></tr>\n", what, value, meaning);
}

std::string Table(const Json& map) {
  const Json& bundle = map["bundle"];
  const Json& quality = map["field_quality"];
  const Json& without = map["loops"];
  const Json& with = map["map"];
  const auto count = [](const Json& stage, const char* key) {
    return fmt::format("{:.0f}", Number(stage, key));
  };
  std::string html = "<table>\n";
  html += Row("images adjusted", count(bundle, "images"), "with the flight's loops closed");
  html += Row("of these weakly tied", count(bundle, "weak_images"), "too few points in common");
  html += Row("reprojection error, median",
              fmt::format("{:.2f} px", Number(bundle, "median_px")),
              "under 1 is good");
  html += Row("poses moved by, mean", fmt::format("{:.3f} m", Number(bundle, "mean_shift_m")), "");
  html += Row("held-out images, rendered",
              fmt::format("{:.1f} dB", Number(quality, "psnr_db")),
              "above 24 is good, under 20 a place is hardly known");
  html +=
      Row("their corners found again",
          fmt::format("{:.0f} %", 100 * Number(quality, "corner_match_rate")),
          quality.contains("corner_match_ceiling") && quality["corner_match_ceiling"].is_number()
              ? fmt::format("of a neighbouring photograph's: {:.0f} %",
                            100 * Number(quality, "corner_match_ceiling"))
              : "");
  if (quality.contains("before")) {
    html += Row("the same by the field as it was",
                fmt::format("{:.1f} dB", Number(quality["before"], "psnr_db")),
                "of the map that was added to");
  }
  html += Row("places", count(with, "places"), "");
  html += Row("virtual views kept", count(with, "views"), "");
  html += Row("loops of the flight, without views", count(without, "loops"), "");
  html += Row("with them", count(with, "loops"), "");
  html += Row(
      "keyframes that found a place again, without views",
      fmt::format("{} of {}", count(without, "keyframes_with_loop"), count(without, "keyframes")),
      "");
  html += Row("with them", count(with, "keyframes_with_loop"), "");
  const Json& gain = map["gain"];
  html += Row("the flight's second half on a map of its first, without views",
              fmt::format("{} of {}", count(gain, "found_without_views"), count(gain, "keyframes")),
              fmt::format("keyframes that found one of its {} places", count(gain, "places")));
  html += Row("with them",
              fmt::format("{} of {}", count(gain, "found_with_views"), count(gain, "keyframes")),
              "");
  html += Row("memory of the map", fmt::format("{:.1f} MB", Number(with, "core_memory_mb")), "");
  html += Row("took",
              fmt::format("{:.0f} s", Number(map, "wall_s")),
              fmt::format("{:.0f} s of processors, {:.0f} MB at most",
                          Number(map, "cpu_s"),
                          Number(map, "peak_rss_mb")));
  return html + "</table>\n";
}

std::string Pictures(const fs::path& directory) {
  std::vector<std::string> names;
  std::error_code error;
  for (const auto& entry : fs::directory_iterator(directory / "pictures", error)) {
    if (entry.path().extension() == ".png") {
      names.push_back(entry.path().filename().string());
    }
  }
  std::sort(names.begin(), names.end());
  std::string html;
  for (const std::string& name : names) {
    html += fmt::format(
        "<figure><img src=\"pictures/{0}\" alt=\"{0}\"><figcaption>{0}</figcaption></figure>\n",
        name);
  }
  return html;
}

}  // namespace

std::vector<std::string> MapAdvice(const Json& map) {
  std::vector<std::string> advice;
  const double images = Number(map["bundle"], "images");
  if (Number(map["bundle"], "weak_images") > 0.1 * images) {
    advice.push_back(fmt::format(
        "{:.0f} of {:.0f} images are tied to few others: fly slower there, or with more light and "
        "texture in view; sideways motion tells more than turning on the spot.",
        Number(map["bundle"], "weak_images"),
        images));
  }
  if (Number(map["bundle"], "median_px") > 1.5) {
    advice.push_back(fmt::format(
        "The points miss their pixels by {:.1f} px: check the camera's calibration, and that its "
        "stamps are those of the images.",
        Number(map["bundle"], "median_px")));
  }
  if (Number(map["field"], "images_outside") > 0.1 * Number(map["field"], "images")) {
    advice.push_back(fmt::format(
        "{:.0f} images are outside of the box that the field was made for, and taught it nothing: "
        "map both flights anew, the wider one first.",
        Number(map["field"], "images_outside")));
  }
  if (Number(map["loops"], "loops") == 0) {
    advice.emplace_back(
        "No place was found again: a flight that comes back to where it was ties the map together. "
        "Without that the drift of the odometry stays in it.");
  }
  const double psnr_db = Number(map["field_quality"], "psnr_db");
  if (psnr_db > 0 && psnr_db < 20) {
    advice.push_back(fmt::format(
        "The field knows the place badly ({:.1f} dB): its views are of little use. Give it more "
        "time (--budget-s), and see in the pictures whether blur or wrong poses are to blame.",
        psnr_db));
  }
  if (Number(map["map"], "views") == 0) {
    advice.emplace_back(
        "No virtual view was kept: the map recognises the place only from where the flight has "
        "been.");
  }
  return advice;
}

void WriteMapPage(const fs::path& directory, const Json& map) {
  std::string html = fmt::format(
      "<!DOCTYPE html>\n<html lang=\"en\"><head><meta charset=\"utf-8\">\n<meta name=\"viewport\" "
      "content=\"width=device-width\">\n<title>Map</title>\n<style>{}</style></head><body>\n"
      "<h1>A map of {:.0f} places</h1>\n",
      kStyle,
      Number(map["map"], "places"));
  const std::vector<std::string> advice = MapAdvice(map);
  if (!advice.empty()) {
    html += "<h2>What would make it better</h2>\n<ul class=\"advice\">\n";
    for (const std::string& line : advice) {
      html += fmt::format("<li>{}</li>\n", line);
    }
    html += "</ul>\n";
  }
  html += "<h2>What was made</h2>\n" + Table(map);
  html += "<h2>Held-out images: photograph and field</h2>\n" + Pictures(directory);
  html += "</body></html>\n";
  WriteFileAtomically(directory / "map.html", [&](std::ostream& out) { out << html; });
}

}  // namespace deja_view
