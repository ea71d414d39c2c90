#include "deja_view/io/options_yaml.hpp"

#include <fstream>

#include "error_messages.hpp"
#include <gmock/gmock.h>
#include <gtest/gtest.h>
#include <unistd.h>

namespace deja_view {

enum class Colour { kRed, kGreen };

template <>
inline constexpr auto kEnumNames<Colour> = EnumNames("red", "green");

namespace {

using ::testing::AllOf;
using ::testing::HasSubstr;

struct Point {
  double x = 0;
  double y = 0;
  template <typename Visitor>
  void Visit(Visitor& v) {
    v("x", x);
    v("y", y);
  }
};

struct Inner {
  bool enabled = false;
  double gain = 0.1;
  template <typename Visitor>
  void Visit(Visitor& v) {
    v("enabled", enabled);
    v("gain", gain);
  }
};

struct Outer {
  int count = 3;
  std::int64_t stamp = 9007199254740993;
  std::uint8_t level = 7;
  std::uint64_t seed = 42;
  float single = 0.3F;
  double limit = 1e300;
  std::string name = "a \"quoted\" \\ name\n";
  std::filesystem::path file = "/tmp/x y";
  Colour colour = Colour::kGreen;
  std::vector<double> radii = {0.02, 0.5};
  std::array<int, 3> shape = {1, 2, 3};
  std::vector<Point> points = {{1, 2}, {3, 4.5}};
  Inner inner;

  template <typename Visitor>
  void Visit(Visitor& v) {
    v("count", count);
    v("stamp", stamp);
    v("level", level);
    v("seed", seed);
    v("single", single);
    v("limit", limit);
    v("name", name);
    v("file", file);
    v("colour", colour);
    v("radii", radii);
    v("shape", shape);
    v("points", points);
    v("inner", inner);
  }

  std::vector<std::string> Validate() const {
    std::vector<std::string> violations;
    if (count < 1) {
      violations.push_back(fmt::format("count: {}, expected at least 1", count));
    }
    if (!(inner.gain > 0)) {
      violations.push_back(fmt::format("inner.gain: {}, expected more than 0", inner.gain));
    }
    return violations;
  }
};

struct TwoOuters {
  Outer first;
  Outer second;
  template <typename Visitor>
  void Visit(Visitor& v) {
    v("first", first);
    v("second", second);
  }
};

std::string ErrorOf(const std::string& text) {
  Outer options;
  options.count = 77;
  try {
    ParseOptions(text, "file.yaml", &options);
  } catch (const InputError& e) {
    EXPECT_EQ(options.count, 77) << "options changed by a bad file";
    return e.what();
  }
  return "no error";
}

TEST(OptionsYaml, SetsWhatTheFileNames) {
  Outer options;
  options.level = 9;
  ParseOptions("count: 5\ncolour: red\nname: plain text\ninner:\n  enabled: true\n", "f", &options);
  EXPECT_EQ(options.count, 5);
  EXPECT_EQ(options.colour, Colour::kRed);
  EXPECT_EQ(options.name, "plain text");
  EXPECT_TRUE(options.inner.enabled);
  EXPECT_EQ(options.inner.gain, 0.1);
  EXPECT_EQ(options.level, 9);
}

TEST(OptionsYaml, WritesWhatItReads) {
  Outer options;
  options.limit = std::numeric_limits<double>::infinity();
  options.inner.gain = 1.0 / 3.0;
  options.single = 16777217.0F / 3.0F;
  options.radii.clear();
  const std::string text = OptionsToYaml(options);
  Outer read;
  ParseOptions(text, "f", &read);
  EXPECT_EQ(OptionsToYaml(read), text);
  EXPECT_EQ(read.name, options.name);
  EXPECT_EQ(read.file, options.file);
  EXPECT_EQ(read.stamp, options.stamp);
  EXPECT_EQ(read.inner.gain, options.inner.gain);
  EXPECT_EQ(read.single, options.single);
  EXPECT_EQ(read.limit, options.limit);
  EXPECT_EQ(read.points[1].y, 4.5);
  EXPECT_TRUE(read.radii.empty());
}

TEST(OptionsYaml, UnknownKeysSuggestTheNearest) {
  EXPECT_THAT(ErrorOf("count: 1\nradius: [1]\n"),
              HasSubstr("file.yaml:2: unknown key 'radius'; did you mean 'radii'?"));
  EXPECT_THAT(ErrorOf("inner:\n  enabeld: true\n"),
              HasSubstr("file.yaml:2: unknown key 'inner.enabeld'; did you mean 'inner.enabled'?"));
}

TEST(OptionsYaml, WrongValuesNameKeyAndExpectation) {
  ExpectErrors(ErrorOf,
               {{"count: 2.5\n", "file.yaml:1: key 'count': expected an integer, found '2.5'"},
                {"count: \"2\"\n", "expected an integer, found text '2'"},
                {"count: 3000000000\n", "from -2147483648 to 2147483647"},
                {"level: 256\n", "from 0 to 255"},
                {"seed: -1\n", "an integer from 0"},
                {"single: 1e60\n", "expected a number"},
                {"limit: .nan\n", "expected a number"},
                {"limit: 1,5\n", "expected a number"},
                {"limit: [1]\n", "expected a number, found a list"},
                {"limit:\n", "expected a number, found nothing"},
                {"name: {a: 1}\n", "expected text, found a map"},
                {"inner: {enabled: \"true\"}\n", "expected true or false"},
                {"colour: blue\n", "expected one of red, green, found 'blue'"},
                {"radii: 3\n", "expected a list"},
                {"radii: [1, x]\n", "key 'radii[1]': expected a number"},
                {"shape: [1, 2]\n", "expected a list of 3 values"},
                {"points: [{x: 1, z: 2}]\n", "unknown key 'points[0].z'"},
                {"inner: 4\n", "expected a map of keys"},
                {"inner:\n  enabled: 1\n",
                 "file.yaml:2: key 'inner.enabled': expected true or false, found '1'"}});
}

TEST(OptionsYaml, BoundsAndEscapesWhatItEchoes) {
  const std::string long_text(5000, 'x');
  EXPECT_LT(ErrorOf("count: " + long_text + "\n").size(), 200U);
  EXPECT_LT(ErrorOf(long_text + ": 1\n").size(), 250U);
  EXPECT_THAT(ErrorOf("count: \"a\\nb\\e[31m\"\n"), HasSubstr("found text 'a\\nb\\x1b[31m'"));
  std::string many;
  for (int i = 0; i < 1000; ++i) {
    many += "unknown" + std::to_string(i) + ": 1\n";
  }
  EXPECT_THAT(ErrorOf(many), HasSubstr("... and 980 more"));
  Outer options;
  try {
    OverrideOption("count=" + long_text, &options);
    ADD_FAILURE() << "no error";
  } catch (const InputError& e) {
    EXPECT_LT(std::string(e.what()).size(), 300U);
  }
}

TEST(OptionsYaml, AllErrorsComeAtOnce) {
  EXPECT_THAT(ErrorOf("count: x\nfoo: 1\ninner:\n  gain: y\n"),
              AllOf(HasSubstr("'count'"), HasSubstr("'foo'"), HasSubstr("'inner.gain'")));
  EXPECT_THAT(ErrorOf("count: 0\ninner: {gain: -1}\n"),
              AllOf(HasSubstr("file.yaml: count: 0"), HasSubstr("inner.gain: -1")));
}

TEST(OptionsYaml, PartsAreValidatedWhereTheWholeIsNot) {
  TwoOuters pair;
  EXPECT_THAT(MessageOf<InputError>([&] {
                ParseOptions("first: {count: 0}\nsecond: {inner: {gain: 0}}\n", "f", &pair);
              }),
              Says("f: first.count: 0, expected at least 1", "f: second.inner.gain: 0"));
  EXPECT_EQ(pair.first.count, 3) << "options changed by a bad file";
}

TEST(OptionsYaml, BadDocumentsAreRefused) {
  ExpectErrors(ErrorOf,
               {{"count: 1\ncount: 2\n", "file.yaml:2: key 'count' appears twice"},
                {"count: [1\n", "file.yaml"},
                {"- 1\n", "expected a map"},
                {"[a]: 1\n", "plain word"},
                {"radii: &a [*a]\n", "file.yaml"}});
  EXPECT_EQ(ErrorOf(""), "no error");
  EXPECT_EQ(ErrorOf("inner:\n"), "no error");
}

TEST(OptionsYaml, ReadsFiles) {
  const std::filesystem::path path = std::filesystem::temp_directory_path() /
                                     ("deja_view_options_" + std::to_string(::getpid()) + ".yaml");
  std::ofstream(path) << "%YAML:1.0\ncount: 12\ninner: {gain: 2}\n";
  const auto options = ReadOptions<Outer>(path);
  EXPECT_EQ(options.count, 12);
  EXPECT_EQ(options.inner.gain, 2.0);
  EXPECT_EQ(options.level, 7);
  Outer overridden;
  ReadOptions(path, {"count=13", "inner.gain=3"}, &overridden);
  EXPECT_EQ(overridden.count, 13) << "the file goes first";
  EXPECT_EQ(overridden.inner.gain, 3.0);
  std::filesystem::remove(path);
  ReadOptions("", {"count=14"}, &overridden);
  EXPECT_EQ(overridden.count, 14);
  EXPECT_THROW(ReadOptions<Outer>(path), InputError);
}

TEST(OptionsYaml, OverridesOneField) {
  Outer options;
  OverrideOption("inner.gain=2.5", &options);
  OverrideOption("radii=[1, 2, 3]", &options);
  OverrideOption("name=two words", &options);
  EXPECT_EQ(options.inner.gain, 2.5);
  EXPECT_EQ(options.radii.size(), 3U);
  EXPECT_EQ(options.name, "two words");
  EXPECT_EQ(options.count, 3);
  EXPECT_THROW(OverrideOption("inner.gian=1", &options), InputError);
  EXPECT_THROW(OverrideOption("inner", &options), InputError);
  EXPECT_THROW(OverrideOption("=1", &options), InputError);
  EXPECT_THROW(OverrideOption("count=", &options), InputError);
  EXPECT_THROW(OverrideOption(".count=1", &options), InputError);
}

}  // namespace
}  // namespace deja_view
