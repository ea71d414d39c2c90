#pragma once

#include "deja_view/base/check.hpp"
#include "deja_view/base/enum_names.hpp"
#include "deja_view/base/quote.hpp"
#include "deja_view/base/requirements.hpp"
#include "deja_view/io/config_node.hpp"

#include <array>
#include <cstdint>
#include <filesystem>
#include <limits>
#include <string>
#include <type_traits>
#include <vector>

#include <fmt/format.h>

/// Options structs to YAML and back, strictly. An options struct lists its fields in a member
///   template <typename Visitor> void Visit(Visitor& v) { v("key", field); v("group", nested); ...
///   }
/// Fields are bool, integers (up to 2^63 - 1), float, double, std::string, std::filesystem::path,
/// enums with EnumNames, std::vector and std::array of these, and structs with their own Visit.
namespace deja_view {
namespace internal {

template <typename T, typename = void>
struct HasVisit : std::false_type {};
struct AnyVisitor {
  template <typename T>
  void operator()(const char* /*key*/, T& /*field*/) {}
};
template <typename T>
struct HasVisit<T, std::void_t<decltype(std::declval<T&>().Visit(std::declval<AnyVisitor&>()))>>
    : std::true_type {};

template <typename T, typename = void>
struct HasValidate : std::false_type {};
template <typename T>
struct HasValidate<T, std::void_t<decltype(std::declval<const T&>().Validate())>> : std::true_type {
};

template <typename T>
struct IsVector : std::false_type {};
template <typename T>
struct IsVector<std::vector<T>> : std::true_type {};
template <typename T>
struct IsArray : std::false_type {};
template <typename T, std::size_t N>
struct IsArray<std::array<T, N>> : std::true_type {};

template <typename T>
constexpr bool kAlwaysFalse = false;

/// Visitor that fills the fields which a map names, and collects what is wrong.
class OptionsReader {
 public:
  /// `prefix` is "" or the path of keys to this map with a dot at its end.
  OptionsReader(const ConfigNode& map,
                std::string file,
                std::string prefix,
                std::vector<std::string>* errors)
      : map_(map), file_(std::move(file)), prefix_(std::move(prefix)), errors_(errors) {}

  template <typename T>
  void operator()(const char* key, T& field) {
    known_.emplace_back(key);
    for (const auto& [name, node] : map_.entries) {
      if (name == key) {
        Read(node, prefix_ + key, field);
      }
    }
  }

  /// Reports the keys that no field has; call after Visit.
  void ReportUnknownKeys() const;

 private:
  template <typename T>
  void Read(const ConfigNode& node, const std::string& key, T& field) {
    if constexpr (std::is_same_v<T, bool>) {
      Assign(node, key, ToBool(node), "true or false", field);
    } else if constexpr (std::is_enum_v<T>) {
      const auto value =
          node.kind == ConfigNode::Kind::kScalar ? EnumFromString<T>(node.scalar) : std::nullopt;
      Assign(node, key, value, "one of " + EnumNameList<T>(), field);
    } else if constexpr (std::is_integral_v<T>) {
      ReadInteger(node, key, field);
    } else if constexpr (std::is_same_v<T, float>) {
      Assign(node, key, ToSingle(node), "a number", field);
    } else if constexpr (std::is_same_v<T, double>) {
      Assign(node, key, ToNumber(node), "a number", field);
    } else if constexpr (std::is_same_v<T, std::string> ||
                         std::is_same_v<T, std::filesystem::path>) {
      const auto value =
          node.kind == ConfigNode::Kind::kScalar ? std::make_optional(node.scalar) : std::nullopt;
      Assign(node, key, value, "text", field);
    } else if constexpr (IsVector<T>::value || IsArray<T>::value) {
      ReadList(node, key, field);
    } else {
      static_assert(HasVisit<T>::value, "a field of an options struct needs a Visit member");
      ReadStruct(node, key, field);
    }
  }

  template <typename Value, typename T>
  void Assign(const ConfigNode& node,
              const std::string& key,
              const std::optional<Value>& value,
              const std::string& expected,
              T& field) {
    if (value) {
      field = *value;
    } else {
      Report(node, key, expected);
    }
  }

  template <typename T>
  void ReadInteger(const ConfigNode& node, const std::string& key, T& field) {
    static_assert(sizeof(T) < 8 || std::is_signed_v<T> || std::is_same_v<T, std::uint64_t>);
    constexpr auto kMin = static_cast<std::int64_t>(std::numeric_limits<T>::min());
    constexpr auto kMax = sizeof(T) < 8 || std::is_signed_v<T>
                              ? static_cast<std::int64_t>(std::numeric_limits<T>::max())
                              : std::numeric_limits<std::int64_t>::max();
    const std::optional<std::int64_t> value = ToInteger(node);
    if (value && *value >= kMin && *value <= kMax) {
      field = static_cast<T>(*value);
    } else {
      Report(
          node,
          key,
          value ? fmt::format("an integer from {} to {}", kMin, kMax) : std::string("an integer"));
    }
  }

  template <typename T>
  void ReadList(const ConfigNode& node, const std::string& key, T& field) {
    if (node.kind != ConfigNode::Kind::kList) {
      Report(node, key, "a list");
      return;
    }
    if constexpr (IsVector<T>::value) {
      field.assign(node.items.size(), {});
    } else if (node.items.size() != field.size()) {
      Report(node, key, fmt::format("a list of {} values", field.size()));
      return;
    }
    for (std::size_t i = 0; i < field.size(); ++i) {
      Read(node.items[i], fmt::format("{}[{}]", key, i), field[i]);
    }
  }

  template <typename T>
  void ReadStruct(const ConfigNode& node, const std::string& key, T& field) {
    if (node.kind == ConfigNode::Kind::kNull) {
      return;  // a heading without anything below: all defaults
    }
    if (node.kind != ConfigNode::Kind::kMap) {
      Report(node, key, "a map of keys");
      return;
    }
    OptionsReader reader(node, file_, key + ".", errors_);
    field.Visit(reader);
    reader.ReportUnknownKeys();
  }

  void Report(const ConfigNode& node, const std::string& key, const std::string& expected);

  const ConfigNode& map_;
  std::string file_;
  std::string prefix_;
  std::vector<std::string>* errors_;
  std::vector<std::string> known_;
};

/// Visitor that writes fields as YAML block maps.
class OptionsWriter {
 public:
  explicit OptionsWriter(int indent = 0) : indent_(indent, ' ') {}

  template <typename T>
  void operator()(const char* key, T& field) {
    if constexpr (HasVisit<T>::value) {
      OptionsWriter nested(static_cast<int>(indent_.size()) + 2);
      field.Visit(nested);
      text_ += nested.text_.empty() ? "" : fmt::format("{}{}:\n{}", indent_, key, nested.text_);
    } else {
      text_ += fmt::format("{}{}: {}\n", indent_, key, Format(field));
    }
  }

  const std::string& text() const { return text_; }

 private:
  template <typename T>
  static std::string Format(const T& value) {
    if constexpr (std::is_same_v<T, bool>) {
      return value ? "true" : "false";
    } else if constexpr (std::is_enum_v<T>) {
      return EnumToString(value);
    } else if constexpr (std::is_integral_v<T>) {
      return fmt::format("{}", +value);  // + prints a uint8_t as a number
    } else if constexpr (std::is_floating_point_v<T>) {
      return FormatNumber(value);
    } else if constexpr (std::is_same_v<T, std::string>) {
      return QuoteYaml(value);
    } else if constexpr (std::is_same_v<T, std::filesystem::path>) {
      return QuoteYaml(value.string());
    } else if constexpr (IsVector<T>::value || IsArray<T>::value) {
      std::string list;
      for (const auto& entry : value) {
        list += (list.empty() ? "" : ", ") + Format(entry);
      }
      return "[" + list + "]";
    } else if constexpr (HasVisit<T>::value) {
      FlowWriter writer;
      T copy = value;
      copy.Visit(writer);
      return "{" + writer.text + "}";
    } else {
      static_assert(kAlwaysFalse<T>, "no YAML form for this type of field");
    }
  }

  // A struct inside a list: {a: 1, b: 2}.
  struct FlowWriter {
    template <typename T>
    void operator()(const char* key, T& field) {
      text += fmt::format("{}{}: {}", text.empty() ? "" : ", ", key, Format(field));
    }
    std::string text;
  };

  // The shortest text that reads back as the same value.
  template <typename T>
  static std::string FormatNumber(T value) {
    if (value == std::numeric_limits<T>::infinity()) {
      return ".inf";
    }
    return value == -std::numeric_limits<T>::infinity() ? "-.inf" : fmt::format("{}", value);
  }

  std::string indent_;
  std::string text_;
};

/// Joins violations into one InputError; nothing when there are none.
void ThrowIfAny(const std::vector<std::string>& errors);

/// Visitor that collects what Validate() of the fields finds.
class PartsValidator {
 public:
  template <typename T>
  void operator()(const char* key, T& field) {
    if constexpr (HasValidate<T>::value) {
      requirements_.Group(key, field.Validate());
    }
  }
  const std::vector<std::string>& errors() const { return requirements_.errors(); }

 private:
  Requirements requirements_;
};

template <typename Options>
void ValidateFrom(const std::string& file, Options* options) {
  std::vector<std::string> violations;
  if constexpr (HasValidate<Options>::value) {
    violations = options->Validate();
  } else {
    PartsValidator parts;
    options->Visit(parts);
    violations = parts.errors();
  }
  for (std::string& violation : violations) {
    violation = fmt::format("{}: {}", file, violation);
  }
  ThrowIfAny(violations);
}

template <typename Options>
void ApplyConfig(const ConfigNode& root, const std::string& file, Options* options) {
  std::vector<std::string> errors;
  OptionsReader reader(root, file, "", &errors);
  options->Visit(reader);
  reader.ReportUnknownKeys();
  ThrowIfAny(errors);
  ValidateFrom(file, options);
}

/// {a: {b: value}} for "a.b=value".
ConfigNode ParseOverride(const std::string& assignment);

}  // namespace internal

/// Sets the fields that the file names; the others keep their value. Then calls Validate(), of the
/// struct's parts if it has none of its own. Throws one InputError with all that is wrong: file and
/// line, key, the value found and what was expected; for an unknown key the nearest known one.
/// `*options` is then left as it was.
template <typename Options>
void ReadOptions(const std::filesystem::path& path, Options* options) {
  Options result = *options;
  internal::ApplyConfig(ReadConfigFile(path), path.string(), &result);
  *options = std::move(result);
}

/// As above, from the defaults.
template <typename Options>
Options ReadOptions(const std::filesystem::path& path) {
  Options options;
  ReadOptions(path, &options);
  return options;
}

/// As ReadOptions, from YAML text; `name` stands for the path in errors.
template <typename Options>
void ParseOptions(const std::string& text, const std::string& name, Options* options) {
  Options result = *options;
  internal::ApplyConfig(ParseConfig(text, name), name, &result);
  *options = std::move(result);
}

/// Sets one field from "group.key=value", e.g. of a command line; errors as ReadOptions.
template <typename Options>
void OverrideOption(const std::string& assignment, Options* options) {
  Options result = *options;
  internal::ApplyConfig(internal::ParseOverride(assignment), Quote(assignment), &result);
  *options = std::move(result);
}

/// Both, as a command line gives them: the file, unless `path` is empty, then each override.
template <typename Options>
void ReadOptions(const std::filesystem::path& path,
                 const std::vector<std::string>& overrides,
                 Options* options) {
  if (!path.empty()) {
    ReadOptions(path, options);
  }
  for (const std::string& assignment : overrides) {
    OverrideOption(assignment, options);
  }
}

/// All fields as YAML, which ReadOptions reads back to the same values.
template <typename Options>
std::string OptionsToYaml(const Options& options) {
  Options copy = options;  // Visit is not const
  internal::OptionsWriter writer;
  copy.Visit(writer);
  return writer.text();
}

}  // namespace deja_view
