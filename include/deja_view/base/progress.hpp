#pragma once

#include <chrono>
#include <cstddef>
#include <ostream>
#include <string>

namespace deja_view {

/// One line of progress for long work: done/total, rate, time left; redrawn in place on a terminal,
/// printed as a new line every ten seconds elsewhere (a log file). Used by tools, not by the
/// library's algorithms, which take a `std::function<void(std::size_t done, std::size_t total)>`
/// instead.
class Progress {
 public:
  /// `unit` names what is counted ("keyframes"); `total` 0 means unknown.
  Progress(std::string label,
           std::string unit,
           std::size_t total,
           std::ostream& stream,
           bool is_terminal);
  /// Writes to standard error, as a terminal if it is one.
  Progress(std::string label, std::string unit, std::size_t total);

  /// For a total that is known only once the work has begun.
  void SetTotal(std::size_t total) { total_ = total; }

  /// Draws when enough time has passed since the last draw. `note` is appended ("PSNR 24.1 dB").
  void Update(std::size_t done, const std::string& note = "");
  /// Draws the final state and ends the line.
  void Finish(std::size_t done, const std::string& note = "");

  /// "done/total unit  rate unit/s  left m:ss", as drawn after `elapsed_s` seconds.
  std::string Format(std::size_t done, double elapsed_s, const std::string& note) const;

 private:
  void Draw(std::size_t done, const std::string& note, bool last);

  std::string label_;
  std::string unit_;
  std::size_t total_;
  std::ostream& stream_;
  bool is_terminal_;
  std::chrono::steady_clock::time_point start_ = std::chrono::steady_clock::now();
  std::chrono::steady_clock::time_point last_draw_{};
};

}  // namespace deja_view
