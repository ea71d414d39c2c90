#include "deja_view/base/check.hpp"
#include "deja_view/base/input_file.hpp"
#include "deja_view/base/quote.hpp"
#include "deja_view/io/tum.hpp"
#include "deja_view/lab/report/run.hpp"

#include <algorithm>
#include <array>
#include <charconv>
#include <cmath>
#include <fstream>
#include <sstream>

namespace deja_view::report {
namespace {

namespace fs = std::filesystem;

constexpr std::array kColumns = {"stamp_current_ns",
                                 "stamp_old_ns",
                                 "tx",
                                 "ty",
                                 "tz",
                                 "qx",
                                 "qy",
                                 "qz",
                                 "qw",
                                 "score",
                                 "inliers",
                                 "virtual",
                                 "accepted",
                                 "reason"};

std::vector<std::string> Split(const std::string& line) {
  std::vector<std::string> cells;
  std::stringstream stream(line);
  std::string cell;
  while (std::getline(stream, cell, ',')) {
    cells.push_back(cell);
  }
  if (!line.empty() && line.back() == ',') {
    cells.emplace_back();
  }
  return cells;
}

/// One row, with its place in the file for errors.
class Row {
 public:
  Row(const fs::path& path, int line, std::vector<std::string> cells, const std::vector<int>& order)
      : path_(path), line_(line), cells_(std::move(cells)), order_(order) {}

  const std::string& Text(std::size_t column) const {
    return cells_.at(static_cast<std::size_t>(order_.at(column)));
  }
  std::int64_t Integer(std::size_t column) const {
    const std::string& text = Text(column);
    std::int64_t value = 0;
    const auto result = std::from_chars(text.data(), text.data() + text.size(), value);
    Expect(column, result.ec == std::errc() && result.ptr == text.data() + text.size(), "a number");
    return value;
  }
  bool Flag(std::size_t column) const {
    const std::int64_t value = Integer(column);
    Expect(column, value == 0 || value == 1, "0 or 1");
    return value == 1;
  }
  double Real(std::size_t column) const {
    std::istringstream stream(Text(column));
    stream.imbue(std::locale::classic());
    double value = 0;
    stream >> value;
    Expect(
        column, !stream.fail() && stream.peek() == EOF && std::isfinite(value), "a finite number");
    return value;
  }
  void Expect(std::size_t column, bool condition, const char* expected) const {
    if (!condition) {
      ThrowInputError("{}:{}: {} is {}, expected {}",
                      path_.string(),
                      line_,
                      kColumns.at(column),
                      Quote(Text(column)),
                      expected);
    }
  }

 private:
  const fs::path& path_;
  int line_;
  std::vector<std::string> cells_;
  const std::vector<int>& order_;
};

std::vector<int> ColumnOrder(const fs::path& path, const std::vector<std::string>& header) {
  std::vector<int> order;
  for (const char* column : kColumns) {
    const auto found = std::find(header.begin(), header.end(), column);
    if (found == header.end()) {
      ThrowInputError("{}:1: expected a column {}", path.string(), column);
    }
    order.push_back(static_cast<int>(found - header.begin()));
  }
  return order;
}

LoopRecord ToLoopRecord(const Row& row) {
  LoopRecord loop;
  loop.stamp_current_ns = row.Integer(0);
  loop.stamp_old_ns = row.Integer(1);
  loop.T_Bold_Bcurrent.t = {row.Real(2), row.Real(3), row.Real(4)};
  const Eigen::Quaterniond q(row.Real(8), row.Real(5), row.Real(6), row.Real(7));
  row.Expect(8, std::abs(q.norm() - 1) < 1e-3, "a quaternion of norm 1");
  loop.T_Bold_Bcurrent.q = q.normalized();
  loop.score = row.Real(9);
  loop.inliers = static_cast<int>(row.Integer(10));
  loop.is_virtual = row.Flag(11);
  loop.accepted = row.Flag(12);
  loop.reason = row.Text(13);
  return loop;
}

std::string LastName(const fs::path& directory) {
  const fs::path absolute = fs::absolute(directory).lexically_normal();
  return (absolute.has_filename() ? absolute : absolute.parent_path()).filename().string();
}

}  // namespace

std::vector<LoopRecord> ReadLoops(const fs::path& path) {
  std::ifstream file = OpenInputFile(path);
  std::string line;
  if (!std::getline(file, line)) {
    ThrowInputError("{}: is empty; expected a CSV file of loops", path.string());
  }
  const std::vector<std::string> header = Split(line);
  const std::vector<int> order = ColumnOrder(path, header);
  std::vector<LoopRecord> loops;
  for (int number = 2; std::getline(file, line); ++number) {
    std::vector<std::string> cells = Split(line);
    if (cells.size() != header.size()) {
      ThrowInputError(
          "{}:{}: {} columns, expected {}", path.string(), number, cells.size(), header.size());
    }
    loops.push_back(ToLoopRecord(Row(path, number, std::move(cells), order)));
  }
  return loops;
}

RunData ReadRun(const fs::path& directory) {
  RunData run;
  run.name = LastName(directory);
  run.corrected = ReadTum(directory / "trajectory.txt");
  run.vio = ReadTum(directory / "vio.txt");
  run.loops = ReadLoops(directory / "loops.csv");
  if (run.corrected.stamps_ns != run.vio.stamps_ns) {
    ThrowInputError("{}: trajectory.txt ({} poses) and vio.txt ({} poses) are not of one run",
                    directory.string(),
                    run.corrected.size(),
                    run.vio.size());
  }
  return run;
}

}  // namespace deja_view::report
