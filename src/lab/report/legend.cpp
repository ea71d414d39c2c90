#include "legend.hpp"

#include <fmt/format.h>

namespace deja_view::report {
namespace {

constexpr double kTextGap = 7;
constexpr double kEntryGap = 26;
constexpr double kMiddle = 4.5;  ///< from the baseline up to the middle of small letters

}  // namespace

void Legend::AddLine(const std::string& css_class, const std::string& text) {
  constexpr double kWidth = 24;
  svg_->AddLine(css_class, at_ - Point(0, kMiddle), at_ + Point(kWidth, -kMiddle));
  AddText(kWidth, text);
}

void Legend::AddDot(const std::string& css_class, const std::string& text) {
  constexpr double kRadius = 3;
  svg_->AddDots(css_class, {at_ + Point(kRadius, -kMiddle)});
  AddText(2 * kRadius, text);
}

void Legend::AddBox(const std::string& css_class, const std::string& text) {
  constexpr double kSize = 12;
  svg_->AddRect(css_class, at_ + Point(0, -kMiddle - kSize / 2), {kSize, kSize}, 2);
  AddText(kSize, text);
}

void Legend::AddErrorScale(double largest) {
  constexpr double kBoxWidth = 9;
  svg_->AddText("small muted", at_, "error  0");
  const double left = TextWidth("error  0") + 2;
  for (int i = 0; i < kErrorColors; ++i) {
    svg_->AddRect("e" + std::to_string(i),
                  at_ + Point(left + i * kBoxWidth, -kMiddle - 5),
                  {kBoxWidth + 0.4, 10});
  }
  AddText(left + kErrorColors * kBoxWidth, fmt::format("{:.3g} m", largest));
}

void Legend::AddText(double sample_width, const std::string& text) {
  const double left = sample_width + kTextGap;
  svg_->AddText("small muted", at_ + Point(left, 0), text);
  at_.x() += left + TextWidth(text) + kEntryGap;
}

}  // namespace deja_view::report
