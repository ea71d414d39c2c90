#pragma once

namespace deja_view::report {

/// Of figures with a title, a legend and axes [px].
constexpr double kWidth = 1080;
constexpr double kLeft = 76;
constexpr double kTop = 78;
constexpr double kRight = 28;
constexpr double kBottom = 50;

}  // namespace deja_view::report
