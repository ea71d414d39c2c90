#include "evaluate/evaluate.hpp"

#include "deja_view/base/check.hpp"
#include "deja_view/ros/bag/bag_reader.hpp"
#include "deja_view/ros/bag/bag_replay.hpp"

#include <algorithm>
#include <cerrno>
#include <fstream>
#include <iostream>
#include <sstream>

#include "common/interrupt.hpp"
#include <fcntl.h>
#include <fmt/format.h>
#include <signal.h>
#include <spawn.h>
#include <sys/wait.h>
#include <unistd.h>

namespace deja_view {
namespace {

namespace fs = std::filesystem;
using Json = nlohmann::ordered_json;

constexpr const char* kBaseline = "no_virtual";

std::vector<std::string> Words(const std::string& text) {
  std::istringstream stream(text);
  std::vector<std::string> words;
  for (std::string word; stream >> word;) {
    words.push_back(word);
  }
  return words;
}

/// The arguments as a shell takes them.
std::string Quoted(const std::vector<std::string>& arguments) {
  std::string line;
  for (const std::string& argument : arguments) {
    const bool is_plain = argument.find_first_not_of(
                              "abcdefghijklmnopqrstuvwxyz"
                              "ABCDEFGHIJKLMNOPQRSTUVWXYZ"
                              "0123456789_-./=,:") == std::string::npos;
    line += (line.empty() ? "" : " ") + (is_plain ? argument : "'" + argument + "'");
  }
  return line;
}

/// Runs this very program; what it prints goes to `log`. Returns its exit status.
int RunSelf(const std::vector<std::string>& arguments, const fs::path& log) {
  const std::string self = fs::read_symlink("/proc/self/exe").string();
  std::vector<std::string> words = {self};
  words.insert(words.end(), arguments.begin(), arguments.end());
  std::vector<char*> argv;
  for (std::string& word : words) {
    argv.push_back(word.data());
  }
  argv.push_back(nullptr);
  posix_spawn_file_actions_t actions;
  posix_spawn_file_actions_init(&actions);
  posix_spawn_file_actions_addopen(
      &actions, STDOUT_FILENO, log.c_str(), O_WRONLY | O_CREAT | O_TRUNC, 0644);
  posix_spawn_file_actions_adddup2(&actions, STDOUT_FILENO, STDERR_FILENO);
  // The child shall heed the signals that Interrupt holds back here.
  posix_spawnattr_t attributes;
  posix_spawnattr_init(&attributes);
  sigset_t none;
  sigemptyset(&none);
  posix_spawnattr_setsigmask(&attributes, &none);
  posix_spawnattr_setflags(&attributes, POSIX_SPAWN_SETSIGMASK);
  pid_t child = 0;
  const int error = posix_spawn(&child, self.c_str(), &actions, &attributes, argv.data(), environ);
  posix_spawnattr_destroy(&attributes);
  posix_spawn_file_actions_destroy(&actions);
  if (error != 0) {
    ThrowInputError("{}: can't be started (error {})", self, error);
  }
  int status = 0;
  while (waitpid(child, &status, 0) < 0 && errno == EINTR) {
  }
  return status;
}

Json ReadJson(const fs::path& path) {
  std::ifstream stream(path);
  return Json::parse(stream, nullptr, false);
}

std::vector<std::string> SharedArguments(const EvaluateRequest& request) {
  std::vector<std::string> arguments = {"replay", "--bag", request.bag.string()};
  const auto add = [&](const char* option, const fs::path& path) {
    if (!path.empty()) {
      arguments.insert(arguments.end(), {option, path.string()});
    }
  };
  add("--camera", request.camera);
  add("--groundtruth", request.groundtruth);
  add("--vocabulary", request.vocabulary);
  add("--config", request.config);
  add("--load-map", request.load_map);
  add("--map-groundtruth", request.map_groundtruth);
  if (request.revisit.size() == 2) {
    arguments.insert(arguments.end(),
                     {"--revisit",
                      fmt::format("{}", request.revisit[0]),
                      fmt::format("{}", request.revisit[1])});
  }
  if (request.localise) {
    arguments.emplace_back("--localise");
  }
  return arguments;
}

Json RunVariant(const EvaluateRequest& request,
                const Variant& variant,
                const Interrupt& interrupt) {
  const fs::path directory = request.out / variant.name;
  fs::create_directories(directory);
  std::vector<std::string> arguments = SharedArguments(request);
  arguments.insert(arguments.end(), variant.arguments.begin(), variant.arguments.end());
  const fs::path json_file = directory / "replay.json";
  arguments.insert(arguments.end(),
                   {"--out", directory.string(), "--json", json_file.string(), "--quiet"});
  const fs::path log = directory / "replay.log";
  fs::remove(json_file);
  const int status = RunSelf(arguments, log);
  interrupt.Check();
  if (status != 0) {
    std::ifstream stream(log);
    std::string said;
    std::getline(stream, said);
    ThrowInputError("variant {}: replay failed: {}; see {}", variant.name, said, log.string());
  }
  Json entry;
  entry["name"] = variant.name;
  entry["arguments"] = Quoted(variant.arguments);
  entry["command"] = "deja_view " + Quoted(arguments);
  const Json results = ReadJson(json_file);
  if (!results.is_object()) {
    ThrowInputError("{}: expected the results of a replay", json_file.string());
  }
  entry.update(results);
  return entry;
}

void AddCosts(Json* variants) {
  const auto baseline = std::find_if(variants->begin(), variants->end(), [](const Json& entry) {
    return entry.at("name") == kBaseline;
  });
  for (Json& entry : *variants) {
    entry["added_cpu_percent"] = nullptr;
    entry["added_rss_mb"] = nullptr;
    if (baseline != variants->end()) {
      const double cpu_s = baseline->at("cpu_s").get<double>();
      entry["added_cpu_percent"] = 100.0 * (entry.at("cpu_s").get<double>() / cpu_s - 1.0);
      entry["added_rss_mb"] =
          entry.at("peak_rss_mb").get<double>() - baseline->at("peak_rss_mb").get<double>();
    }
  }
}

}  // namespace

std::vector<Variant> MakeVariants(const EvaluateRequest& request, bool bag_has_views) {
  std::vector<Variant> variants = {{kBaseline, {"--virtual", "off"}}};
  if (bag_has_views) {
    variants.push_back({"virtual", {}});
    variants.push_back({"virtual_best1", {"--set", "views.keep=1"}});
  }
  for (const auto& [name, bag] : request.virtual_bags) {
    variants.push_back({"virtual_" + name, {"--virtual-bag", bag.string()}});
  }
  // The paper finds places by words alone.
  const auto add_scored = [&](const std::string& name, const std::string& setting) {
    variants.push_back(
        {name, {"--set", "scoring.is_on=true", "--set", "candidates.nearby=0", "--set", setting}});
  };
  for (const char* weights : {"tfidf", "printed", "text", "synonym"}) {
    add_scored(fmt::format("weights_{}", weights), fmt::format("scoring.weights={}", weights));
  }
  for (const char* threshold : {"sum", "pair"}) {
    add_scored(fmt::format("threshold_{}", threshold),
               fmt::format("scoring.threshold={}", threshold));
  }
  for (const double spacing : request.spacings_m) {
    const std::vector<std::string> arguments = {"--map-spacing", fmt::format("{}", spacing)};
    variants.push_back({fmt::format("spacing_{}_no_virtual", spacing), arguments});
    variants.back().arguments.insert(variants.back().arguments.end(), {"--virtual", "off"});
    if (bag_has_views || !request.virtual_bags.empty()) {
      variants.push_back({fmt::format("spacing_{}_virtual", spacing), arguments});
      if (!bag_has_views) {
        variants.back().arguments.insert(
            variants.back().arguments.end(),
            {"--virtual-bag", request.virtual_bags.front().second.string()});
      }
    }
  }
  for (const auto& [name, arguments] : request.extra) {
    variants.push_back({name, Words(arguments)});
  }
  if (!request.only.empty()) {
    variants.erase(std::remove_if(variants.begin(),
                                  variants.end(),
                                  [&](const Variant& variant) {
                                    return std::find(request.only.begin(),
                                                     request.only.end(),
                                                     variant.name) == request.only.end();
                                  }),
                   variants.end());
  }
  return variants;
}

Json RunEvaluate(const EvaluateRequest& request) {
  const Interrupt interrupt;
  const bool bag_has_views = BagReader(request.bag).HasTopic(VioTopics{}.virtual_frame);
  const std::vector<Variant> variants = MakeVariants(request, bag_has_views);
  if (variants.empty()) {
    ThrowInputError("--only: none of the names is a variant's");
  }
  Json results = Json::array();
  for (const Variant& variant : variants) {
    interrupt.Check();
    if (request.show_progress) {
      std::cerr << fmt::format("[{}/{}] {} {}\n",
                               results.size() + 1,
                               variants.size(),
                               variant.name,
                               Quoted(variant.arguments));
    }
    results.push_back(RunVariant(request, variant, interrupt));
  }
  AddCosts(&results);
  Json json;
  json["version"] = DEJA_VIEW_VERSION;
  json["bag"] = request.bag.string();
  json["groundtruth"] = request.groundtruth.string();
  json["variants"] = std::move(results);
  return json;
}

}  // namespace deja_view
