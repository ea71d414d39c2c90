#include "deja_view/io/tum.hpp"

#include "deja_view/base/atomic_file.hpp"
#include "deja_view/base/check.hpp"

#include <algorithm>
#include <array>
#include <cerrno>
#include <charconv>
#include <cmath>
#include <cstdlib>
#include <cstring>
#include <fstream>
#include <limits>
#include <sstream>
#include <vector>

#include "append_pose.hpp"
#include "parse_number.hpp"

namespace deja_view {
namespace {

constexpr int kColumns = 8;

bool IsDigit(char c) {
  return c >= '0' && c <= '9';
}

// digits * 10^exponent; `digits` holds 1 to 40 digits, exponent is at least -80 and at most 40.
struct Decimal {
  std::string digits;
  int exponent = 0;
};

std::optional<Decimal> ParseDecimal(std::string_view text) {
  constexpr int kMaxExponent = 40;
  Decimal decimal;
  std::size_t end = std::min(text.find_first_of("eE"), text.size());
  const std::string_view mantissa = text.substr(0, end);
  const std::size_t point = std::min(mantissa.find('.'), mantissa.size());
  decimal.digits = mantissa.substr(0, point);
  if (point < mantissa.size()) {
    decimal.digits += mantissa.substr(point + 1);
    decimal.exponent = -static_cast<int>(mantissa.size() - point - 1);
  }
  if (decimal.digits.empty() || decimal.digits.size() > 40 ||
      !std::all_of(decimal.digits.begin(), decimal.digits.end(), IsDigit)) {
    return std::nullopt;
  }
  if (end < text.size()) {
    ++end;
    end += text.substr(end, 1) == "+" ? 1 : 0;
    int power = 0;
    const auto result = std::from_chars(text.data() + end, text.data() + text.size(), power);
    if (result.ec != std::errc() || result.ptr != text.data() + text.size() ||
        std::abs(power) > kMaxExponent) {
      return std::nullopt;
    }
    decimal.exponent += power;
  }
  return decimal;
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
  std::optional<Decimal> decimal = ParseDecimal(text);
  if (!decimal) {
    return std::nullopt;
  }
  std::string& digits = decimal->digits;
  const int shift = decimal->exponent + 9;  // to nanoseconds
  bool rounds_up = false;
  if (shift >= 0) {
    digits.append(static_cast<std::size_t>(shift), '0');
  } else {
    const auto cut = static_cast<std::size_t>(-shift);
    digits.insert(0, cut, '0');
    rounds_up = digits[digits.size() - cut] >= '5';
    digits.resize(digits.size() - cut);
  }
  std::int64_t value = 0;
  const auto result = std::from_chars(digits.data(), digits.data() + digits.size(), value);
  if (result.ec != std::errc() || value == std::numeric_limits<std::int64_t>::max()) {
    return std::nullopt;
  }
  return value + (rounds_up ? 1 : 0);
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
