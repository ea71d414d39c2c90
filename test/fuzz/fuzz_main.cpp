// Runs a fuzz target. Built with clang and -DDEJA_VIEW_FUZZ=ON it is libFuzzer's, which explores
// (scripts/fuzz). Otherwise it changes the target's seeds at random from a fixed seed:
//   TARGET [--seconds S] [--memory-mb M] [--seed N]   for so long, and with at most so much memory
//   TARGET FILE...                                    these inputs
//   TARGET --seeds DIR                                writes the seeds there
#include "deja_view/base/check.hpp"
#include "deja_view/base/hash.hpp"

#include <algorithm>
#include <chrono>
#include <cstdint>
#include <cstdlib>
#include <cstring>
#include <ctime>
#include <fstream>
#include <iostream>
#include <iterator>
#include <random>

#include "fuzz.hpp"
#include <sys/resource.h>
#include <sys/time.h>
#include <unistd.h>

namespace deja_view::fuzz {
namespace {

namespace fs = std::filesystem;

struct ScratchFolder {
  ScratchFolder() {
    const fs::path root = fs::is_directory("/dev/shm") ? "/dev/shm" : fs::temp_directory_path();
    path = root / ("deja_view_fuzz_" + std::to_string(::getpid()));
    fs::create_directories(path);
  }
  ~ScratchFolder() {
    std::error_code error;
    fs::remove_all(path, error);
  }
  ScratchFolder(const ScratchFolder&) = delete;
  ScratchFolder& operator=(const ScratchFolder&) = delete;

  fs::path path;
};

void RunGuarded(const std::string& input) {
  try {
    RunOne(input);
  } catch (const InputError&) {
    // What bad input is meant to end in.
  }
}

void WriteSeeds(const fs::path& directory) {
  fs::create_directories(directory);
  int number = 0;
  for (const std::string& seed : Seeds()) {
    std::ofstream(directory / ("seed_" + std::to_string(number++)), std::ios::binary) << seed;
  }
}

}  // namespace

const fs::path& Scratch() {
  static const ScratchFolder folder;
  return folder.path;
}

fs::path Write(const std::string& name, const std::string& bytes) {
  const fs::path path = Scratch() / name;
  fs::create_directories(path.parent_path());
  std::ofstream(path, std::ios::binary | std::ios::trunc) << bytes;
  return path;
}

std::string ReadAll(const fs::path& path) {
  std::ifstream stream(path, std::ios::binary);
  return {std::istreambuf_iterator<char>(stream), {}};
}

void Seal(std::string* file) {
  constexpr std::size_t kHead = 24;  // magic, version, 0, length of the body
  constexpr std::size_t kTail = 8;   // hash of the body
  if (file->size() < kHead + kTail) {
    return;
  }
  const std::uint64_t size = file->size() - kHead - kTail;
  const std::uint64_t hash = Hash64(file->data() + kHead, size);
  std::memcpy(file->data() + kHead - sizeof(size), &size, sizeof(size));
  std::memcpy(file->data() + kHead + size, &hash, sizeof(hash));
}

Prefixed SplitPrefix(const std::string& input) {
  return input.empty() ? Prefixed()
                       : Prefixed{static_cast<unsigned char>(input[0]), input.substr(1)};
}

}  // namespace deja_view::fuzz

extern "C" int LLVMFuzzerTestOneInput(const std::uint8_t* data, std::size_t size) {
  deja_view::fuzz::RunGuarded({reinterpret_cast<const char*>(data), size});
  return 0;
}

#ifdef DEJA_VIEW_LIBFUZZER
extern "C" int LLVMFuzzerInitialize(int* /*argc*/, char*** /*argv*/) {
  if (const char* directory = std::getenv("DEJA_VIEW_FUZZ_SEEDS")) {
    deja_view::fuzz::WriteSeeds(directory);
    std::exit(0);
  }
  return 0;
}
#else
namespace deja_view::fuzz {
namespace {

using Clock = std::chrono::steady_clock;

// An input that computes longer, or waits longer, hangs: a signal ends the program.
constexpr unsigned kComputesS = 20;
constexpr unsigned kWaitsS = 600;  // a busy machine makes all wait

void LimitTime(unsigned computes_s, unsigned waits_s) {
  const itimerval limit = {{0, 0}, {static_cast<time_t>(computes_s), 0}};
  ::setitimer(ITIMER_PROF, &limit, nullptr);
  ::alarm(waits_s);
}

double ProcessorSeconds() {
  return static_cast<double>(std::clock()) / CLOCKS_PER_SEC;
}

class Mutator {
 public:
  Mutator(std::vector<std::string> seeds, std::uint64_t seed)
      : seeds_(std::move(seeds)), random_(seed) {}

  std::string Next() {
    std::string input = seeds_[Below(seeds_.size())];
    for (std::size_t changes = Below(6); changes > 0; --changes) {
      Change(&input);
    }
    return input;
  }

 private:
  std::size_t Below(std::size_t end) { return end == 0 ? 0 : random_() % end; }

  void Change(std::string* input) {
    const std::size_t at = Below(input->size());
    const std::size_t left = input->size() - at;
    const std::size_t length = 1 + Below(std::min<std::size_t>(left, 64));
    switch (Below(8)) {
      case 0:
        input->insert(at, 1 + Below(8), static_cast<char>(random_()));
        break;
      case 1:
        input->erase(at, length);
        break;
      case 2:
        input->insert(at, input->substr(Below(input->size()), length));
        break;
      case 3:
        input->resize(at);
        break;
      case 4:
        OverwriteNumber(at, input);
        break;
      case 5:
        ReplaceDigits(at, input);
        break;
      case 6: {
        const std::string& other = seeds_[Below(seeds_.size())];
        input->replace(at, length, other.substr(Below(other.size()), length));
        break;
      }
      default:
        if (left > 0) {
          (*input)[at] = static_cast<char>(random_());
        }
    }
  }

  // A count or length that is too large, or a number that is none.
  void OverwriteNumber(std::size_t at, std::string* input) {
    static const std::uint64_t kNumbers[] = {0,
                                             1,
                                             0x7F,
                                             0xFF,
                                             0xFFFF,
                                             0x7FFFFFFF,
                                             0xFFFFFFFF,
                                             0x7FC00000,          // NaN of a float
                                             0x7FF8000000000000,  // and of a double
                                             0x7FF0000000000000,
                                             0x7FFFFFFFFFFFFFFF,
                                             0xFFFFFFFFFFFFFFFF};
    const std::uint64_t number = kNumbers[Below(std::size(kNumbers))];
    const std::size_t size = std::min<std::size_t>(std::size_t{1} << Below(4), input->size() - at);
    std::memcpy(input->data() + at, &number, size);
  }

  void ReplaceDigits(std::size_t at, std::string* input) {
    static const char* const kWords[] = {
        "nan", "-1", "1e999", "99999999999999999999", "inf", "0", "", "-0.0", "\"", "[", "{", "\n"};
    const std::size_t first = input->find_first_of("0123456789", at);
    if (first != std::string::npos) {
      const std::size_t end = input->find_first_not_of("0123456789.", first);
      input->replace(first, end - first, kWords[Below(std::size(kWords))]);
    }
  }

  std::vector<std::string> seeds_;
  std::mt19937_64 random_;
};

double PeakMemoryMb() {
  struct rusage usage {};
  ::getrusage(RUSAGE_SELF, &usage);
  return static_cast<double>(usage.ru_maxrss) / 1024;
}

int Explore(double seconds, double memory_mb, std::uint64_t seed) {
  const auto end = Clock::now() + std::chrono::duration<double>(seconds);
  std::uint64_t inputs = 0;
  const fs::path last = Scratch() / "last_input";
  Mutator mutator(Seeds(), seed);
  double slowest = 0;
  for (const std::string& whole : Seeds()) {
    RunOne(whole);  // nothing is wrong with these
  }
  for (; Clock::now() < end; ++inputs) {
    const std::string input = mutator.Next();
    Write("last_input", input);
    LimitTime(kComputesS, kWaitsS);
    const double begin = ProcessorSeconds();
    try {
      RunGuarded(input);
    } catch (const std::exception& e) {
      const fs::path kept =
          fs::temp_directory_path() / ("deja_view_fuzz_" + std::to_string(::getpid()));
      fs::copy_file(last, kept, fs::copy_options::overwrite_existing);
      std::cerr << "fault: " << e.what() << "; the input is " << kept.string() << "\n";
      return 1;
    }
    LimitTime(0, 0);
    slowest = std::max(slowest, ProcessorSeconds() - begin);
  }
  std::cout << inputs << " inputs, the slowest " << slowest << " s, " << PeakMemoryMb() << " MB\n";
  return PeakMemoryMb() > memory_mb ? 1 : 0;
}

}  // namespace
}  // namespace deja_view::fuzz

int main(int argc, char** argv) {
  namespace fuzz = deja_view::fuzz;
  double seconds = 2;
  double memory_mb = 1000;
  std::uint64_t seed = 1;
  const std::vector<std::string> arguments(argv + 1, argv + argc);
  bool has_files = false;
  for (std::size_t i = 0; i < arguments.size(); ++i) {
    const bool has_value = i + 1 < arguments.size();
    if (arguments[i] == "--seconds" && has_value) {
      seconds = std::stod(arguments[++i]);
    } else if (arguments[i] == "--memory-mb" && has_value) {
      memory_mb = std::stod(arguments[++i]);
    } else if (arguments[i] == "--seed" && has_value) {
      seed = std::stoull(arguments[++i]);
    } else if (arguments[i] == "--seeds" && has_value) {
      fuzz::WriteSeeds(arguments[++i]);
      return 0;
    } else {
      fuzz::RunGuarded(fuzz::ReadAll(arguments[i]));
      has_files = true;
    }
  }
  return has_files ? 0 : fuzz::Explore(seconds, memory_mb, seed);
}
#endif
