#include "deja_view/io/trajectory_file.hpp"

#include "deja_view/base/check.hpp"
#include "deja_view/base/input_file.hpp"
#include "deja_view/base/quote.hpp"
#include "deja_view/io/colmap.hpp"
#include "deja_view/io/tum.hpp"

#include <algorithm>
#include <charconv>
#include <fstream>
#include <optional>
#include <vector>

#include "append_pose.hpp"
#include "parse_number.hpp"

namespace deja_view {
namespace {

namespace fs = std::filesystem;

constexpr std::size_t kColumns = 8;

std::vector<std::string> SplitCells(const std::string& line) {
  std::vector<std::string> cells(1);
  for (const char c : line) {
    if (c == ',') {
      cells.emplace_back();
    } else if (c != ' ' && c != '\t' && c != '\r') {
      cells.back() += c;
    }
  }
  return cells;
}

struct Row {
  std::int64_t stamp_ns = 0;
  Rigid3 pose;
};

std::optional<Row> ParseRow(const std::vector<std::string>& cells) {
  Row row;
  if (cells.size() < kColumns) {
    return std::nullopt;
  }
  const std::string& stamp = cells[0];
  const auto result = std::from_chars(stamp.data(), stamp.data() + stamp.size(), row.stamp_ns);
  if (result.ec != std::errc() || result.ptr != stamp.data() + stamp.size() || row.stamp_ns < 0) {
    return std::nullopt;
  }
  std::vector<double> values;
  for (std::size_t i = 1; i < kColumns; ++i) {
    const auto value = internal::ParseNumber<double>(cells[i]);
    if (!value) {
      return std::nullopt;
    }
    values.push_back(*value);
  }
  row.pose.t = {values[0], values[1], values[2]};
  row.pose.q = Eigen::Quaterniond(values[3], values[4], values[5], values[6]);
  return row;
}

// True when the first line that is no comment has commas.
bool HasCommas(const fs::path& path) {
  std::ifstream stream = OpenInputFile(path);
  for (std::string line; std::getline(stream, line);) {
    const std::size_t first = line.find_first_not_of(" \t\r");
    if (first != std::string::npos && line[first] != '#') {
      return line.find(',') != std::string::npos;
    }
  }
  return false;
}

fs::path FindAslTruth(const fs::path& directory) {
  for (const char* below : {"mav0/state_groundtruth_estimate0/data.csv",
                            "state_groundtruth_estimate0/data.csv",
                            "data.csv"}) {
    if (fs::is_regular_file(directory / below)) {
      return directory / below;
    }
  }
  ThrowInputError(
      "{}: expected a model of COLMAP, or EuRoC's mav0/state_groundtruth_estimate0/data.csv",
      directory.string());
}

}  // namespace

Trajectory ReadCsvTrajectory(const fs::path& path) {
  std::ifstream stream = OpenInputFile(path);
  Trajectory trajectory;
  std::string line;
  for (int number = 1; std::getline(stream, line); ++number) {
    const std::size_t first = line.find_first_not_of(" \t\r");
    if (first == std::string::npos || line[first] == '#') {
      continue;
    }
    const std::string where = fmt::format("{}:{}", path.string(), number);
    const std::optional<Row> row = ParseRow(SplitCells(line));
    if (!row) {
      ThrowInputError(
          "{}: expected 'stamp_ns, tx, ty, tz, qw, qx, qy, qz, ...', found {}", where, Quote(line));
    }
    internal::AppendPose(where, row->stamp_ns, row->pose, &trajectory);
  }
  return trajectory;
}

TrajectoryFile ReadTrajectoryFile(const fs::path& path) {
  if (path.extension() == ".bag") {
    ThrowInputError("{}: is a bag: the topic of the poses has to be named", path.string());
  }
  TrajectoryFile file;
  if (fs::is_directory(path) && IsColmapModel(path)) {
    file = {TrajectoryFormat::kColmap, ToTrajectory(ReadColmapModel(path)), true};
  } else if (fs::is_directory(path)) {
    file = {TrajectoryFormat::kCsv, ReadCsvTrajectory(FindAslTruth(path)), false};
  } else if (HasCommas(path)) {
    file = {TrajectoryFormat::kCsv, ReadCsvTrajectory(path), false};
  } else {
    file = {TrajectoryFormat::kTum, ReadTum(path), false};
  }
  if (file.trajectory.empty()) {
    ThrowInputError("{}: holds no pose", path.string());
  }
  return file;
}

fs::path FindAslImages(const fs::path& directory) {
  for (const char* below : {"mav0/cam0/data", "cam0/data"}) {
    if (fs::is_directory(directory / below)) {
      return directory / below;
    }
  }
  return directory;
}

}  // namespace deja_view
