#pragma once

#include "deja_view/pipeline/loop_closer.hpp"

#include <array>
#include <cstddef>
#include <cstdint>
#include <filesystem>
#include <functional>
#include <set>
#include <utility>
#include <vector>

namespace deja_view {

/// What loops.csv tells of a loop: a seventh of a report, since a flight keeps all of them.
struct LoopRow {
  LoopRow() = default;
  LoopRow(const LoopReport& report);  // NOLINT(google-explicit-constructor): a part of it

  std::int64_t stamp_current_ns = 0;
  std::int64_t stamp_old_ns = 0;
  std::array<float, 3> t_Bold_Bcurrent = {};  ///< [m]
  std::array<float, 4> q_Bold_Bcurrent = {};  ///< x, y, z, w
  float score = 0;
  int current = -1;  ///< index of the keyframe
  int old = -1;
  int inliers = 0;
  bool is_virtual = false;
  RejectReason reason = RejectReason::kNone;

  bool accepted() const { return reason == RejectReason::kNone; }
};

/// Marks the newest accepted row of each (old, current) of `loops` as withdrawn and erases the pair
/// there; true for any. `Rows`: of LoopRow or LoopReport.
template <typename Rows>
bool MarkWithdrawn(Rows* rows, std::set<std::pair<int, int>>* loops) {
  bool is_any = false;
  for (auto row = rows->rbegin(); row != rows->rend() && !loops->empty(); ++row) {
    if (row->accepted() && loops->erase({row->old, row->current}) > 0) {
      row->reason = RejectReason::kWithdrawn;
      is_any = true;
    }
  }
  return is_any;
}

/// All rows of a flight, in the order of decision. Memory does not grow with the flight: all but
/// the newest few thousand rows lie in a file without a name, which ends with the process. Where
/// none can be written, or the disk is full, they stay in memory.
class LoopRows {
 public:
  /// The file is made in `directory` when the first rows go there; with an empty one it never is.
  explicit LoopRows(std::filesystem::path directory = {});
  ~LoopRows();
  LoopRows(const LoopRows&) = delete;
  LoopRows& operator=(const LoopRows&) = delete;

  void Add(const LoopRow& row);
  /// Marks the newest accepted row of each (old, current) keyframes as withdrawn. Every one must be
  /// there. Throws InputError when the file can't be read or written any more.
  void Withdraw(std::set<std::pair<int, int>> loops);
  std::size_t size() const { return filed_ + newest_.size(); }
  std::size_t in_memory() const { return newest_.size(); }
  /// Throws InputError when the file can't be read any more.
  void ForEach(const std::function<void(const LoopRow&)>& visit) const;

 private:
  bool FileOldest();
  std::vector<LoopRow> ReadBlock(std::size_t first) const;
  [[noreturn]] void Throw(const char* what) const;

  std::filesystem::path directory_;
  int descriptor_ = -1;
  bool can_file_ = true;
  std::size_t filed_ = 0;  ///< rows in the file, whole blocks
  std::vector<LoopRow> newest_;
};

}  // namespace deja_view
