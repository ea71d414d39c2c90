// Procedural grey textures. All sizes below are for 1024 texels and scaled to the size asked for.
#include "deja_view/lab/sim/texture.hpp"

#include <algorithm>
#include <array>
#include <cmath>
#include <string>

#include <opencv2/core.hpp>
#include <opencv2/imgproc.hpp>

namespace deja_view::sim {
namespace {

/// A canvas of linear reflectance with drawing primitives in units of 1/1024 of its side.
class Canvas {
 public:
  Canvas(int size, double value, Rng& rng)
      : scale_(size / 1024.0), image_(size, size, CV_32F, cv::Scalar(value)), rng_(rng) {}

  cv::Mat& image() { return image_; }
  Rng& rng() { return rng_; }
  int Texels(double length) const { return cvRound(length * scale_); }
  int Thickness(double length) const { return std::max(1, Texels(length)); }
  cv::Point At(double x, double y) const { return {Texels(x), Texels(y)}; }

  void Box(double x, double y, double w, double h, double value, double line = 0) {
    const int thickness = line > 0 ? Thickness(line) : cv::FILLED;
    cv::rectangle(image_, At(x, y), At(x + w, y + h), cv::Scalar(value), thickness);
  }
  void Circle(double x, double y, double radius, double value, double line = 0) {
    const int thickness = line > 0 ? Thickness(line) : cv::FILLED;
    cv::circle(image_, At(x, y), Thickness(radius), cv::Scalar(value), thickness, cv::LINE_AA);
  }
  void Line(double x0, double y0, double x1, double y1, double value, double width) {
    cv::line(image_, At(x0, y0), At(x1, y1), cv::Scalar(value), Thickness(width), cv::LINE_AA);
  }
  void Text(const std::string& text, double x, double y, double height, double value, int font) {
    const double font_scale = height / 22.0 * scale_;
    cv::putText(image_,
                text,
                At(x, y),
                font,
                font_scale,
                cv::Scalar(value),
                Thickness(height / 8.0),
                cv::LINE_AA);
  }
  /// Multiplies by 1 + amount * noise, noise in about [-1, 1].
  void Weather(int cells, int octaves, double gain, double amount) {
    cv::Mat noise = Noise(cells, octaves, gain);
    image_ = image_.mul(1.0 + amount * noise);
  }

  /// Sum of `octaves` octaves of smooth noise that repeats with the texture; mean 0, range about
  /// [-1, 1].
  cv::Mat Noise(int cells, int octaves, double gain) {
    const int size = image_.cols;
    cv::Mat sum = cv::Mat::zeros(size, size, CV_32F);
    double amplitude = 1.0;
    double total = 0.0;
    for (int n = cells; octaves > 0 && n <= size; n *= 2, --octaves, amplitude *= gain) {
      sum += amplitude * NoiseOctave(n);
      total += amplitude;
    }
    return total > 0 ? cv::Mat(sum * (1.4 / total)) : sum;
  }

 private:
  cv::Mat NoiseOctave(int n) {
    constexpr int kPad = 2;
    cv::Mat grid(n, n, CV_32F);
    for (int i = 0; i < n * n; ++i) {
      grid.at<float>(i / n, i % n) = static_cast<float>(rng_.Uniform(-1, 1));
    }
    cv::Mat padded;
    cv::copyMakeBorder(grid, padded, kPad, kPad, kPad, kPad, cv::BORDER_WRAP);
    const int step = image_.cols / n;
    cv::Mat large;
    cv::resize(padded, large, cv::Size(), step, step, cv::INTER_CUBIC);
    return large(cv::Rect(kPad * step, kPad * step, image_.cols, image_.rows)).clone();
  }

  double scale_;
  cv::Mat image_;
  Rng& rng_;
};

void DrawConcrete(Canvas& c) {
  Rng& rng = c.rng();
  c.image() = 0.42 + 0.16 * c.Noise(4, 8, 0.62);
  for (int i = 0; i < 420; ++i) {
    c.Circle(
        rng.Uniform(0, 1024), rng.Uniform(0, 1024), rng.Uniform(1, 5), rng.Uniform(0.12, 0.75));
  }
  for (int i = 0; i < 26; ++i) {
    const double x = rng.Uniform(0, 1024);
    const double y = rng.Uniform(0, 1024);
    const double radius = rng.Uniform(12, 60);
    c.Circle(x, y, radius, rng.Uniform(0.24, 0.6), rng.Chance(0.5) ? 0.0 : rng.Uniform(3, 8));
  }
  for (int crack = 0; crack < 10; ++crack) {
    double x = rng.Uniform(0, 1024);
    double y = rng.Uniform(0, 1024);
    double heading = rng.Uniform(0, 6.28);
    for (int i = 0; i < 60; ++i) {
      heading += 0.35 * rng.Normal();
      const double next_x = x + 9 * std::cos(heading);
      const double next_y = y + 9 * std::sin(heading);
      c.Line(x, y, next_x, next_y, 0.16, 2.5);
      x = next_x;
      y = next_y;
    }
  }
  c.Weather(16, 5, 0.7, 0.15);
}

void DrawPlaster(Canvas& c) {
  Rng& rng = c.rng();
  c.image() = 0.58 + 0.05 * c.Noise(4, 7, 0.6);
  for (int i = 0; i < 70; ++i) {
    const double x = rng.Uniform(0, 1024);
    const double y = rng.Uniform(0, 1024);
    if (rng.Chance(0.3)) {
      c.Line(x, y, x + 40 * rng.Normal(), y + 60 * rng.Normal(), rng.Uniform(0.35, 0.7), 2);
    } else {
      c.Circle(x, y, rng.Uniform(2, 9), rng.Uniform(0.3, 0.75));
    }
  }
}

void DrawBrick(Canvas& c) {
  Rng& rng = c.rng();
  constexpr double kWidth = 128;
  constexpr double kHeight = 64;
  for (int row = 0; row < 16; ++row) {
    for (int column = 0; column < 8; ++column) {
      const double x = column * kWidth + (row % 2) * kWidth / 2;
      const double value = rng.Uniform(0.2, 0.52);
      for (const double shift : {0.0, -1024.0}) {
        c.Box(x + shift + 4, row * kHeight + 4, kWidth - 8, kHeight - 8, value);
        if (rng.Chance(0.25)) {
          const double chip = rng.Uniform(8, 22);
          c.Box(x + shift + rng.Uniform(6, 90), row * kHeight + 6, chip, chip, value * 0.5);
        }
      }
    }
  }
  c.Weather(8, 7, 0.65, 0.28);
}

void DrawPlanks(Canvas& c) {
  Rng& rng = c.rng();
  constexpr double kWidth = 128;
  cv::Mat grain = c.Noise(256, 2, 0.7);
  cv::blur(grain, grain, cv::Size(1, c.Thickness(70)));
  for (int plank = 0; plank < 8; ++plank) {
    const double x = plank * kWidth;
    c.Box(x, 0, kWidth, 1024, rng.Uniform(0.22, 0.5));
    for (int knot = rng.Index(4); knot > 0; --knot) {
      c.Circle(x + rng.Uniform(24, 100), rng.Uniform(0, 1024), rng.Uniform(6, 16), 0.1, 4);
    }
    const double joint = rng.Uniform(0, 1024);
    c.Line(x, joint, x + kWidth, joint, 0.07, 6);
    for (const double nail : {22.0, 106.0}) {
      c.Circle(x + nail, joint - 20, 5, 0.75);
      c.Circle(x + nail, joint + 20, 5, 0.75);
    }
    c.Line(x, 0, x, 1024, 0.06, 6);
  }
  c.image() = c.image() + 0.35 * grain;
  c.Weather(8, 6, 0.6, 0.15);
}

void DrawPanels(Canvas& c) {
  Rng& rng = c.rng();
  constexpr double kSide = 256;
  for (int i = 0; i < 16; ++i) {
    const double x = i % 4 * kSide;
    const double y = i / 4 * kSide;
    c.Box(x, y, kSide, kSide, rng.Uniform(0.34, 0.5));
    c.Box(x + 3, y + 3, kSide - 6, kSide - 6, 0.18, 5);
    for (const double dx : {26.0, 128.0, 230.0}) {
      for (const double dy : {26.0, 230.0}) {
        c.Circle(x + dx, y + dy, 9, 0.78);
        c.Circle(x + dx + 2, y + dy + 2, 10, 0.12, 2);
      }
    }
    const int kind = rng.Index(4);
    for (int slot = 0; kind == 0 && slot < 7; ++slot) {
      c.Box(x + 60, y + 60 + slot * 20, 136, 7, 0.08);
    }
    if (kind == 1) {
      c.Box(x + 70, y + 80, 116, 70, 0.85);
      c.Text(std::to_string(100 + rng.Index(900)), x + 76, y + 135, 40, 0.08, 0);
    }
    if (kind == 2) {
      c.Circle(x + 128, y + 128, 50, rng.Uniform(0.1, 0.9));
      c.Circle(x + 128, y + 128, 36, rng.Uniform(0.1, 0.9));
      const double angle = rng.Uniform(0, 6.28);
      c.Line(x + 128,
             y + 128,
             x + 128 + 34 * std::cos(angle),
             y + 128 + 34 * std::sin(angle),
             0.05,
             6);
    }
  }
  for (int i = 0; i < 40; ++i) {
    const double x = rng.Uniform(0, 1024);
    const double y = rng.Uniform(0, 1024);
    c.Line(x, y, x + 60 * rng.Normal(), y + 60 * rng.Normal(), rng.Uniform(0.2, 0.75), 2);
  }
  c.Weather(4, 7, 0.6, 0.12);
}

/// A matrix code: squares at random, so that every poster has places like no other.
void DrawCode(Canvas& c, double x, double y, double cell, double ink) {
  const int cells = 7 + c.rng().Index(4);
  for (int i = 0; i < cells * cells; ++i) {
    if (c.rng().Chance(0.5)) {
      c.Box(x + i % cells * cell, y + i / cells * cell, cell, cell, ink);
    }
  }
}

void DrawPoster(Canvas& c) {
  static constexpr std::array<const char*, 18> kWords = {"DANGER",
                                                         "EXIT 4",
                                                         "PUMP B7",
                                                         "VALVE",
                                                         "380 V",
                                                         "CAUTION",
                                                         "ROTOR",
                                                         "NO ENTRY",
                                                         "LAB 12",
                                                         "TURBINE",
                                                         "A-113",
                                                         "OIL",
                                                         "GAS 2",
                                                         "ETA 0.93",
                                                         "LOCK OUT",
                                                         "MIND HEAD",
                                                         "BAY 6",
                                                         "CRANE 5T"};
  Rng& rng = c.rng();
  const std::array<double, 5> papers = {0.85, 0.7, 0.5, 0.2, 0.12};
  const double paper = papers[static_cast<std::size_t>(rng.Index(5))];
  const double ink = paper > 0.4 ? 0.07 : 0.85;
  c.image().setTo(paper);
  for (double y = 130; y < 980;) {
    const double height = rng.Uniform(26, 105);
    const auto word = static_cast<std::size_t>(rng.Index(static_cast<int>(kWords.size())));
    c.Text(kWords.at(word), rng.Uniform(30, 260), y, height, ink, rng.Index(5));
    y += height * 1.2 + 40;
  }
  for (int i = 3 + rng.Index(6); i > 0; --i) {
    const double x = rng.Uniform(80, 800);
    const double y = rng.Uniform(80, 800);
    const double radius = rng.Uniform(30, 130);
    const double value = rng.Uniform(0.05, 0.9);
    const double line = rng.Chance(0.5) ? 0.0 : rng.Uniform(8, 18);
    if (rng.Chance(0.4)) {
      c.Circle(x, y, radius, value, line);
    } else {
      c.Box(x, y, radius, radius * rng.Uniform(0.6, 1.6), value, line);
    }
  }
  if (rng.Chance(0.6)) {
    DrawCode(c, rng.Uniform(60, 600), rng.Uniform(60, 600), rng.Uniform(18, 40), ink);
  }
  c.Box(8, 8, 1008, 1008, ink, 22);
  c.Weather(4, 6, 0.6, 0.08);
}

void DrawShelf(Canvas& c) {
  Rng& rng = c.rng();
  c.image().setTo(0.09);
  constexpr int kRows = 4;
  constexpr double kRow = 1024.0 / kRows;
  for (int row = 0; row < kRows; ++row) {
    const double base = (row + 1) * kRow - 18;
    for (double x = 12; x < 970;) {
      const double width = std::min(rng.Uniform(40, 170), 1012 - x);
      const double height = rng.Uniform(kRow / 2, kRow - 34);
      const double value = rng.Uniform(0.16, 0.85);
      c.Box(x, base - height, width, height, value);
      c.Box(x, base - height, width, height, value * 0.4, 3);
      if (rng.Chance(0.7)) {
        const double label = value < 0.5 ? 0.85 : 0.08;
        c.Box(x + width / 6, base - height * 0.6, width * 0.66, height * 0.28, label);
        c.Text(std::to_string(rng.Index(1000)),
               x + width / 6 + 3,
               base - height * 0.36,
               std::max(10.0, width * 0.25),
               0.9 - label,
               0);
      }
      x += width + rng.Uniform(4, 30);
    }
    c.Box(0, base, 1024, 18, 0.5);
  }
  c.Weather(8, 6, 0.6, 0.12);
}

void DrawCamouflage(Canvas& c) {
  cv::Mat noise = c.Noise(16, 6, 0.75);
  cv::Mat dark = noise < 0.0;
  c.image().setTo(0.5);
  c.image().setTo(0.22, dark);
  c.Weather(32, 5, 0.8, 0.3);
}

void DrawLacquer(Canvas& c) {
  Rng& rng = c.rng();
  c.image() = 0.03 + 0.004 * c.Noise(4, 6, 0.6);
  for (int i = 0; i < 8; ++i) {
    const double x = rng.Uniform(0, 1024);
    const double y = rng.Uniform(0, 1024);
    c.Line(x, y, x + 40 * rng.Normal(), y + 40 * rng.Normal(), rng.Uniform(0.04, 0.07), 2);
  }
}

}  // namespace

Texture MakeTexture(Material material, int size, double strength, Rng rng) {
  Canvas canvas(size, 0.5, rng);
  switch (material) {
    case Material::kConcrete:
      DrawConcrete(canvas);
      break;
    case Material::kPlaster:
      DrawPlaster(canvas);
      break;
    case Material::kBrick:
      DrawBrick(canvas);
      break;
    case Material::kPlanks:
      DrawPlanks(canvas);
      break;
    case Material::kPanels:
      DrawPanels(canvas);
      break;
    case Material::kPoster:
      DrawPoster(canvas);
      break;
    case Material::kShelf:
      DrawShelf(canvas);
      break;
    case Material::kCamouflage:
      DrawCamouflage(canvas);
      break;
    case Material::kLacquer:
      DrawLacquer(canvas);
      break;
  }
  cv::Mat image = canvas.image();
  const double mean = cv::mean(image)[0];
  image = mean + strength * (image - mean);
  cv::flip(image, image, 0);  // row 0 is drawn as the top; v points up
  return Texture(cv::min(cv::max(image, 0.02), 0.95));
}

}  // namespace deja_view::sim
