#include "deja_view/io/tum.hpp"

#include "deja_view/base/atomic_file.hpp"
#include "deja_view/base/check.hpp"

#include <array>
#include <cerrno>
#include <charconv>
#include <cmath>
#include <cstring>
#include <fstream>
#include <sstream>
#include <vector>

#include "parse_number.hpp"

namespace deja_view {
namespace {

constexpr int kColumns = 8;

bool IsDigit(char c) {
  return c >= '0' && c <= '9';
}

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

std::optional<std::int64_t> ParseSeconds(std::string_view text) {
  constexpr std::size_t kMaxDigits = 40;
  std::string digits;
  int exponent = 9;  // of ten, from the number that the digits form to nanoseconds
  std::size_t i = 0;
  bool is_fraction = false;
  bool has_digit = false;
  for (; i < text.size() && (IsDigit(text[i]) || (text[i] == '.' && !is_fraction)); ++i) {
    if (text[i] == '.') {
      is_fraction = true;
      continue;
    }
    has_digit = true;
    digits += text[i];
    exponent -= is_fraction ? 1 : 0;
  }
  if (i < text.size() && (text[i] == 'e' || text[i] == 'E')) {
    const std::size_t first = i + 1 < text.size() && text[i + 1] == '+' ? i + 2 : i + 1;
    int power = 0;
    const auto result = std::from_chars(text.data() + first, text.data() + text.size(), power);
    if (result.ec != std::errc() || std::abs(power) > 40) {
      return std::nullopt;
    }
    exponent += power;
    i = static_cast<std::size_t>(result.ptr - text.data());
  }
  if (!has_digit || i != text.size() || digits.size() > kMaxDigits) {
    return std::nullopt;
  }
  // Shift the decimal point behind the nanoseconds; the first digit cut off rounds.
  bool rounds_up = false;
  if (exponent >= 0) {
    digits.append(static_cast<std::size_t>(exponent), '0');
  } else {
    const auto cut = static_cast<std::size_t>(-exponent);
    digits.insert(0, cut, '0');
    rounds_up = digits[digits.size() - cut] >= '5';
    digits.resize(digits.size() - cut);
  }
  std::int64_t value = 0;
  const auto result = std::from_chars(digits.data(), digits.data() + digits.size(), value);
  if (digits.empty() || (result.ec == std::errc() && value < INT64_MAX)) {
    return value + (rounds_up ? 1 : 0);
  }
  return std::nullopt;
}

std::string FormatSeconds(std::int64_t stamp_ns) {
  DEJA_VIEW_CHECK_OP(stamp_ns, >=, 0);
  constexpr std::int64_t kSecond = 1000000000;
  return fmt::format("{}.{:09d}", stamp_ns / kSecond, stamp_ns % kSecond);
}

Trajectory ReadTum(const std::filesystem::path& path) {
  std::ifstream stream(path);
  if (!stream || std::filesystem::is_directory(path)) {
    ThrowInputError("{}: can't be opened: {}", path.string(), std::strerror(errno));
  }
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
      ThrowInputError("{}:{}: expected 'stamp tx ty tz qx qy qz qw', found '{}'",
                      path.string(),
                      number,
                      line.substr(0, 120));
    }
    if (!(std::abs(pose->q.norm() - 1.0) < 1e-3)) {
      ThrowInputError("{}:{}: expected a unit quaternion, found one of norm {:.6g}",
                      path.string(),
                      number,
                      pose->q.norm());
    }
    if (!trajectory.empty() && *stamp <= trajectory.stamps_ns.back()) {
      ThrowInputError("{}:{}: expected a stamp later than {}, found {}",
                      path.string(),
                      number,
                      FormatSeconds(trajectory.stamps_ns.back()),
                      words[0]);
    }
    trajectory.stamps_ns.push_back(*stamp);
    trajectory.poses.push_back({pose->q.normalized(), pose->t});
  }
  return trajectory;
}

void WriteTum(const std::filesystem::path& path, const Trajectory& trajectory) {
  DEJA_VIEW_CHECK_OP(trajectory.stamps_ns.size(), ==, trajectory.poses.size());
  WriteFileAtomically(path, [&](std::ostream& stream) {
    stream << "# timestamp tx ty tz qx qy qz qw\n";
    for (std::size_t i = 0; i < trajectory.size(); ++i) {
      const Eigen::Vector3d& t = trajectory.poses[i].t;
      const Eigen::Quaterniond& q = trajectory.poses[i].q;
      stream << fmt::format("{} {:.9f} {:.9f} {:.9f} {:.9f} {:.9f} {:.9f} {:.9f}\n",
                            FormatSeconds(trajectory.stamps_ns[i]),
                            t.x(),
                            t.y(),
                            t.z(),
                            q.x(),
                            q.y(),
                            q.z(),
                            q.w());
    }
  });
}

}  // namespace deja_view
