#include "deja_view/io/tum.hpp"

#include "deja_view/base/atomic_file.hpp"
#include "deja_view/base/check.hpp"
#include "deja_view/base/input_file.hpp"
#include "deja_view/base/quote.hpp"
#include "deja_view/io/seconds.hpp"

#include <array>
#include <fstream>
#include <optional>
#include <sstream>
#include <string>
#include <vector>

#include "append_pose.hpp"
#include "parse_number.hpp"

namespace deja_view {
namespace {

constexpr int kColumns = 8;

// Seven finite numbers after the stamp; nothing for anything else.
std::optional<Rigid3> ParsePose(const std::vector<std::string>& words) {
  std::array<double, kColumns - 1> values{};
  for (std::size_t i = 0; i < values.size(); ++i) {
    const auto value = internal::ParseNumber<double>(words[i + 1]);
    if (!value) {
      return std::nullopt;
    }
    values[i] = *value;
  }
  Rigid3 pose;
  pose.t = {values[0], values[1], values[2]};
  pose.q = Eigen::Quaterniond(values[6], values[3], values[4], values[5]);
  return pose;
}

std::vector<std::string> SplitWords(const std::string& line) {
  std::istringstream stream(line);
  std::vector<std::string> words;
  for (std::string word; stream >> word;) {
    words.push_back(word);
  }
  return words;
}

}  // namespace

Trajectory ReadTum(const std::filesystem::path& path) {
  std::ifstream stream = OpenInputFile(path);
  Trajectory trajectory;
  std::string line;
  for (int number = 1; std::getline(stream, line); ++number) {
    const std::vector<std::string> words = SplitWords(line);
    if (words.empty() || words[0][0] == '#') {
      continue;
    }
    const auto stamp = ParseSeconds(words[0]);
    const auto pose = words.size() == kColumns ? ParsePose(words) : std::nullopt;
    if (!stamp || !pose) {
      ThrowInputError("{}:{}: expected 'stamp tx ty tz qx qy qz qw', found {}",
                      path.string(),
                      number,
                      Quote(line));
    }
    const std::string where = fmt::format("{}:{}", path.string(), number);
    internal::AppendPose(where, *stamp, *pose, &trajectory);
  }
  return trajectory;
}

void WriteTum(const std::filesystem::path& path, const Trajectory& trajectory) {
  DEJA_VIEW_CHECK_OP(trajectory.stamps_ns.size(), ==, trajectory.poses.size());
  WriteFileAtomically(path, [&](std::ostream& stream) {
    stream << "# timestamp tx ty tz qx qy qz qw\n";
    for (std::size_t i = 0; i < trajectory.size(); ++i) {
      stream << fmt::format("{} {:.9f} {:.9f}\n",
                            FormatSeconds(trajectory.stamps_ns[i]),
                            fmt::join(Numbers(trajectory.poses[i].t), " "),
                            fmt::join(ScalarLast(trajectory.poses[i].q), " "));
    }
  });
}

}  // namespace deja_view
