#include "message_layout.hpp"

#include "deja_view/base/check.hpp"

#include <algorithm>
#include <array>
#include <cstring>
#include <sstream>
#include <string_view>
#include <utility>

namespace deja_view::internal {
namespace {

// http://wiki.ros.org/msg
constexpr std::array<std::pair<std::string_view, std::size_t>, 15> kNumbers = {{{"bool", 1},
                                                                                {"int8", 1},
                                                                                {"uint8", 1},
                                                                                {"byte", 1},
                                                                                {"char", 1},
                                                                                {"int16", 2},
                                                                                {"uint16", 2},
                                                                                {"int32", 4},
                                                                                {"uint32", 4},
                                                                                {"int64", 8},
                                                                                {"uint64", 8},
                                                                                {"float32", 4},
                                                                                {"float64", 8},
                                                                                {"time", 8},
                                                                                {"duration", 8}}};

std::size_t SizeOfNumber(std::string_view type) {
  const auto* found = std::find_if(
      kNumbers.begin(), kNumbers.end(), [&](const auto& number) { return number.first == type; });
  return found == kNumbers.end() ? 0 : found->second;
}

}  // namespace

bool MessageLayout::Bytes::Skip(std::uint64_t count) {
  if (count > left) {
    return false;
  }
  at += count;
  left -= count;
  return true;
}

bool MessageLayout::Bytes::Read(std::uint32_t* count) {
  const std::uint8_t* from = at;
  if (!Skip(sizeof(*count))) {
    return false;
  }
  std::memcpy(count, from, sizeof(*count));
  return true;
}

MessageLayout::MessageLayout(const std::string& type, const std::string& definition) {
  types_.push_back({type, {}});
  std::istringstream lines(definition);
  constexpr std::string_view kTypeBegins = "MSG: ";
  for (std::string line; std::getline(lines, line);) {
    if (line.compare(0, kTypeBegins.size(), kTypeBegins) == 0) {
      types_.push_back({line.substr(kTypeBegins.size()), {}});
    } else if (line.compare(0, 2, "==") != 0) {
      AddField(line, &types_.back());
    }
  }
  Resolve();
}

void MessageLayout::AddField(const std::string& line, Type* type) {
  std::istringstream words(line.substr(0, line.find('#')));
  Field field;
  if (!(words >> field.type >> field.name) || field.name.find('=') != std::string::npos) {
    return;
  }
  std::string rest;
  if (words >> rest) {
    return;  // a constant, with '=' between spaces
  }
  const std::size_t bracket = field.type.find('[');
  if (bracket != std::string::npos) {
    const std::string count = field.type.substr(bracket + 1, field.type.size() - bracket - 2);
    field.is_array = true;
    field.count = count.empty() ? kAnyCount : static_cast<std::uint32_t>(std::stoul(count));
    field.type.erase(bracket);
  }
  field.size = SizeOfNumber(field.type);
  field.is_text = field.type == "string";
  type->fields.push_back(std::move(field));
}

void MessageLayout::Resolve() {
  for (Type& type : types_) {
    const std::string package = type.name.substr(0, type.name.find('/') + 1);
    for (Field& field : type.fields) {
      if (field.size > 0 || field.is_text) {
        continue;
      }
      const std::string name = field.type == "Header"                      ? "std_msgs/Header"
                               : field.type.find('/') == std::string::npos ? package + field.type
                                                                           : field.type;
      const auto found = std::find_if(
          types_.begin(), types_.end(), [&](const Type& other) { return other.name == name; });
      DEJA_VIEW_CHECK(found != types_.end());
      field.nested = static_cast<std::size_t>(found - types_.begin());
    }
  }
}

std::string MessageLayout::FindOverrun(const std::uint8_t* data, std::size_t size) const {
  Bytes bytes{data, size};
  return Walk(types_.front(), &bytes);
}

// NOLINTNEXTLINE(misc-no-recursion): no type of message holds itself.
std::string MessageLayout::Walk(const Type& type, Bytes* bytes) const {
  for (const Field& field : type.fields) {
    std::string overrun = WalkField(field, bytes);
    if (!overrun.empty()) {
      return overrun;
    }
  }
  return {};
}

// NOLINTNEXTLINE(misc-no-recursion): see Walk.
std::string MessageLayout::WalkField(const Field& field, Bytes* bytes) const {
  std::uint32_t count = field.count;
  if (count == kAnyCount && !bytes->Read(&count)) {
    return field.name;
  }
  if (field.size > 0) {
    return bytes->Skip(std::uint64_t{count} * field.size) ? "" : field.name;
  }
  // Each entry takes a byte at least, so that the loop ends with the bytes.
  if (field.is_array && count > bytes->left) {
    return field.name;
  }
  for (std::uint32_t i = 0; i < count; ++i) {
    if (field.is_text) {
      std::uint32_t length = 0;
      if (!bytes->Read(&length) || !bytes->Skip(length)) {
        return field.name;
      }
      continue;
    }
    const std::string overrun = Walk(types_[field.nested], bytes);
    if (!overrun.empty()) {
      return field.name + "." + overrun;
    }
  }
  return {};
}

}  // namespace deja_view::internal
