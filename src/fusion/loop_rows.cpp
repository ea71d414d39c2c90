#include "deja_view/fusion/loop_rows.hpp"

#include "deja_view/base/check.hpp"

#include <algorithm>
#include <cerrno>
#include <cstdlib>
#include <string>
#include <system_error>
#include <type_traits>

#include <fcntl.h>
#include <unistd.h>

namespace deja_view {
namespace {

static_assert(std::is_trivially_copyable_v<LoopRow>);

constexpr std::size_t kBlockRows = 2048;

template <int kSize>
std::array<float, kSize> Floats(const Eigen::Matrix<double, kSize, 1>& values) {
  std::array<float, kSize> floats = {};
  for (int i = 0; i < kSize; ++i) {
    floats[static_cast<std::size_t>(i)] = static_cast<float>(values[i]);
  }
  return floats;
}

int OpenNameless(const std::filesystem::path& directory) {
  std::string name = (directory / ".deja_view_loops_XXXXXX").string();
  const int descriptor = ::mkostemp(name.data(), O_CLOEXEC);
  if (descriptor >= 0) {
    ::unlink(name.c_str());
  }
  return descriptor;
}

off_t OffsetOf(std::size_t row) {
  return static_cast<off_t>(row * sizeof(LoopRow));
}

bool WriteAll(int descriptor, const LoopRow* rows, std::size_t count, std::size_t first) {
  const auto* bytes = reinterpret_cast<const char*>(rows);
  const std::size_t size = count * sizeof(LoopRow);
  std::size_t done = 0;
  while (done < size) {
    const ssize_t written =
        ::pwrite(descriptor, bytes + done, size - done, OffsetOf(first) + static_cast<off_t>(done));
    if (written == 0 || (written < 0 && errno != EINTR)) {
      return false;
    }
    done += written > 0 ? static_cast<std::size_t>(written) : 0;
  }
  return true;
}

}  // namespace

LoopRow::LoopRow(const LoopReport& report)
    : stamp_current_ns(report.stamp_current_ns),
      stamp_old_ns(report.stamp_old_ns),
      t_Bold_Bcurrent(Floats<3>(report.T_Bold_Bcurrent.t)),
      q_Bold_Bcurrent(Floats<4>(report.T_Bold_Bcurrent.q.coeffs())),
      score(static_cast<float>(report.score)),
      current(report.current),
      old(report.old),
      inliers(report.inliers),
      is_virtual(report.is_virtual),
      reason(report.reason) {}

LoopRows::LoopRows(std::filesystem::path directory)
    : directory_(std::move(directory)), can_file_(!directory_.empty()) {}

LoopRows::~LoopRows() {
  if (descriptor_ >= 0) {
    ::close(descriptor_);
  }
}

void LoopRows::Add(const LoopRow& row) {
  newest_.push_back(row);
  if (can_file_ && newest_.size() >= 2 * kBlockRows) {
    can_file_ = FileOldest();
  }
}

bool LoopRows::FileOldest() {
  descriptor_ = descriptor_ >= 0 ? descriptor_ : OpenNameless(directory_);
  if (descriptor_ < 0 || !WriteAll(descriptor_, newest_.data(), kBlockRows, filed_)) {
    return false;
  }
  filed_ += kBlockRows;
  newest_.erase(newest_.begin(), newest_.begin() + static_cast<std::ptrdiff_t>(kBlockRows));
  return true;
}

std::vector<LoopRow> LoopRows::ReadBlock(std::size_t first) const {
  std::vector<LoopRow> rows(kBlockRows);
  auto* bytes = reinterpret_cast<char*>(rows.data());
  const std::size_t size = rows.size() * sizeof(LoopRow);
  std::size_t done = 0;
  while (done < size) {
    const ssize_t read =
        ::pread(descriptor_, bytes + done, size - done, OffsetOf(first) + static_cast<off_t>(done));
    if (read == 0 || (read < 0 && errno != EINTR)) {
      Throw("read");
    }
    done += read > 0 ? static_cast<std::size_t>(read) : 0;
  }
  return rows;
}

void LoopRows::Withdraw(std::set<std::pair<int, int>> loops) {
  MarkWithdrawn(&newest_, &loops);
  for (std::size_t end = filed_; end > 0 && !loops.empty(); end -= kBlockRows) {
    std::vector<LoopRow> rows = ReadBlock(end - kBlockRows);
    if (MarkWithdrawn(&rows, &loops) &&
        !WriteAll(descriptor_, rows.data(), rows.size(), end - kBlockRows)) {
      Throw("written");
    }
  }
  DEJA_VIEW_CHECK(loops.empty());
}

void LoopRows::ForEach(const std::function<void(const LoopRow&)>& visit) const {
  for (std::size_t first = 0; first < filed_; first += kBlockRows) {
    for (const LoopRow& row : ReadBlock(first)) {
      visit(row);
    }
  }
  std::for_each(newest_.begin(), newest_.end(), visit);
}

void LoopRows::Throw(const char* what) const {
  ThrowInputError("{}: the flight's loops can't be {} there: {}",
                  directory_.string(),
                  what,
                  std::generic_category().message(errno));
}

}  // namespace deja_view
