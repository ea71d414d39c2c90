#include "deja_view/lab/report/svg.hpp"

#include <algorithm>
#include <array>
#include <cmath>
#include <cstddef>

#include <fmt/format.h>

namespace deja_view::report {
namespace {

using Color = std::array<double, 3>;

/// What differs between light and dark pages.
struct Palette {
  const char* page;
  const char* text;
  const char* muted;
  const char* grid;
  const char* axis;
  const char* truth;
  const char* vio;
  const std::array<const char*, 4> runs;  ///< corrected trajectories
  const char* correct;
  const char* wrong;
  const char* refused;
  const char* revisit;
  const std::array<Color, 4> error;  ///< stops of the error scale, sRGB
};

// The error scale goes from blue over violet and pink to orange: told apart with any kind of colour
// blindness, and of much the same contrast to the page all along.
constexpr Palette kLight = {"#ffffff",
                            "#1f2328",
                            "#59636e",
                            "#eceef1",
                            "#c4cad1",
                            "#a3acb6",
                            "#d9580b",
                            {"#1c6dd0", "#12805c", "#8a3ffc", "#b5179e"},
                            "#12805c",
                            "#cf222e",
                            "#c3cad2",
                            "#d7ecdf",
                            {{{37, 99, 235}, {139, 60, 230}, {219, 39, 119}, {240, 100, 20}}}};
constexpr Palette kDark = {"#0d1117",
                           "#e6edf3",
                           "#9198a1",
                           "#1d232b",
                           "#3d444d",
                           "#656d77",
                           "#f0883e",
                           {"#58a6ff", "#3fb950", "#bc8cff", "#f778ba"},
                           "#3fb950",
                           "#ff7b72",
                           "#4b535d",
                           "#16351f",
                           {{{79, 140, 255}, {170, 120, 255}, {245, 110, 175}, {255, 180, 100}}}};

/// Rules that are the same on every page; inliers lie on photographs.
constexpr const char* kShapes =
    "text{font-family:Inter,system-ui,-apple-system,'Segoe UI',Roboto,'DejaVu Sans',sans-serif;"
    "font-size:13px}\n"
    ".title{font-size:16px;font-weight:600}\n"
    ".small{font-size:12px}\n"
    ".halo{stroke-width:4;stroke-linejoin:round;paint-order:stroke}\n"
    "path{fill:none;stroke-linejoin:round;stroke-linecap:round}\n"
    ".grid,.axis{stroke-width:1;stroke-linecap:butt}\n"
    ".scale{stroke-width:2;stroke-linecap:butt}\n"
    ".truth{stroke-width:1.6}\n"
    ".vio,.run0,.run1,.run2,.run3{stroke-width:2}\n"
    ".mean{stroke-width:1.2;stroke-dasharray:5 4;stroke-linecap:butt;opacity:.75}\n"
    "path.area{stroke:none;opacity:.12}\n"
    ".loop{stroke-width:.9;opacity:.4}\n"
    ".detection{stroke-width:1;stroke-linecap:butt}\n"
    "path.bar{stroke:none}\n"
    ".match{stroke-width:1;opacity:.7}\n"
    ".inlier{stroke:#2fc97a}.viewinlier{stroke:#b98aff}\n"
    ".dashed{stroke-dasharray:6 4;stroke-linecap:butt}\n"
    ".tick{stroke-width:1;opacity:.6;stroke-linecap:butt}\n"
    ".dot{stroke-width:4.2}\n"
    ".smalldot{stroke-width:3}\n";

void AddStroke(const char* name, const char* color, std::string* css) {
  *css += fmt::format(".{}{{stroke:{}}}\n", name, color);
}

std::string ErrorColor(const Palette& palette, int index) {
  const double u = 3.0 * index / (kErrorColors - 1);
  const auto lower = static_cast<std::size_t>(std::min(2.0, std::floor(u)));
  const double v = u - static_cast<double>(lower);
  std::array<int, 3> rgb{};
  for (std::size_t c = 0; c < 3; ++c) {
    rgb.at(c) = static_cast<int>(std::lround((1 - v) * palette.error.at(lower).at(c) +
                                             v * palette.error.at(lower + 1).at(c)));
  }
  return fmt::format("#{:02x}{:02x}{:02x}", rgb[0], rgb[1], rgb[2]);
}

std::string Colors(const Palette& p) {
  std::string css =
      fmt::format(".page{{fill:{0}}}\ntext{{fill:{1}}}\n.muted{{fill:{2}}}\n.halo{{stroke:{0}}}\n",
                  p.page,
                  p.text,
                  p.muted);
  AddStroke("grid", p.grid, &css);
  AddStroke("axis", p.axis, &css);
  AddStroke("scale", p.muted, &css);
  AddStroke("truth", p.truth, &css);
  AddStroke("vio", p.vio, &css);
  css += fmt::format(".area.vio,path.bar.vio{{fill:{}}}\n", p.vio);
  for (std::size_t i = 0; i < p.runs.size(); ++i) {
    AddStroke(fmt::format("run{}", i).c_str(), p.runs.at(i), &css);
    css += fmt::format(".area.run{0},path.bar.run{0}{{fill:{1}}}\n", i, p.runs.at(i));
  }
  AddStroke("correct", p.correct, &css);
  AddStroke("wrong", p.wrong, &css);
  AddStroke("refused", p.refused, &css);
  css += fmt::format("path.revisit{{fill:{0}}}\nrect.revisit{{fill:{0}}}\n", p.revisit);
  css += fmt::format(".frame{{fill:{}}}\n", p.grid);
  css += fmt::format(".mark{{fill:{};stroke:{};stroke-width:2}}\n", p.page, p.text);
  for (int i = 0; i < kErrorColors; ++i) {
    const std::string color = ErrorColor(p, i);
    css += fmt::format(".e{0}{{stroke:{1}}}\nrect.e{0}{{fill:{1};stroke:none}}\n", i, color);
  }
  css += ".error{stroke-width:2.4}\n";
  return css;
}

}  // namespace

const std::string& StyleSheet() {
  static const std::string css =
      kShapes + Colors(kLight) + "@media (prefers-color-scheme:dark){\n" + Colors(kDark) + "}\n";
  return css;
}

}  // namespace deja_view::report
