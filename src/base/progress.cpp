#include "deja_view/base/progress.hpp"

#include <iostream>
#include <utility>

#include <fmt/format.h>
#include <unistd.h>

namespace deja_view {
namespace {

using Clock = std::chrono::steady_clock;

std::string FormatSeconds(double seconds) {
  const auto whole = static_cast<long>(seconds + 0.5);
  if (whole >= 3600) {
    return fmt::format("{}:{:02}:{:02}", whole / 3600, whole / 60 % 60, whole % 60);
  }
  return fmt::format("{}:{:02}", whole / 60, whole % 60);
}

}  // namespace

Progress::Progress(
    std::string label, std::string unit, std::size_t total, std::ostream& stream, bool is_terminal)
    : label_(std::move(label)),
      unit_(std::move(unit)),
      total_(total),
      stream_(stream),
      is_terminal_(is_terminal) {}

Progress::Progress(std::string label, std::string unit, std::size_t total)
    : Progress(std::move(label), std::move(unit), total, std::cerr, ::isatty(STDERR_FILENO) == 1) {}

std::string Progress::Format(std::size_t done, double elapsed_s, const std::string& note) const {
  const double rate = elapsed_s > 0 ? static_cast<double>(done) / elapsed_s : 0.0;
  std::string text = total_ > 0 ? fmt::format("{}: {}/{} {}", label_, done, total_, unit_)
                                : fmt::format("{}: {} {}", label_, done, unit_);
  text += fmt::format("  {:.4g} {}/s", rate, unit_);
  if (total_ > done && rate > 0) {
    text += fmt::format("  left {}", FormatSeconds(static_cast<double>(total_ - done) / rate));
  } else {
    text += fmt::format("  took {}", FormatSeconds(elapsed_s));
  }
  if (!note.empty()) {
    text += "  " + note;
  }
  return text;
}

void Progress::Update(std::size_t done, const std::string& note) {
  const auto interval =
      is_terminal_ ? std::chrono::milliseconds(200) : std::chrono::milliseconds(10000);
  const auto now = Clock::now();
  if (last_draw_ == Clock::time_point{}) {
    last_draw_ = start_;
  }
  if (now - last_draw_ >= interval) {
    Draw(done, note, false);
    last_draw_ = now;
  }
}

void Progress::Finish(std::size_t done, const std::string& note) {
  Draw(done, note, true);
}

void Progress::Draw(std::size_t done, const std::string& note, bool last) {
  const double elapsed_s = std::chrono::duration<double>(Clock::now() - start_).count();
  const std::string text = Format(done, elapsed_s, note);
  if (is_terminal_) {
    stream_ << '\r' << text << "\x1b[K" << (last ? "\n" : "") << std::flush;
  } else {
    stream_ << text << '\n' << std::flush;
  }
}

}  // namespace deja_view
