#include "deja_view/base/check.hpp"
#include "deja_view/base/hash.hpp"
#include "deja_view/pipeline/loop_closer.hpp"

#include <algorithm>
#include <cmath>
#include <csignal>
#include <cstring>
#include <filesystem>
#include <fstream>
#include <iterator>
#include <random>

#include "place_finder.hpp"
#include "small_flight.hpp"
#include <gtest/gtest.h>
#include <sys/resource.h>

namespace deja_view {
namespace {

namespace fs = std::filesystem;
using test::MakeCloser;
using test::SmallFlight;

constexpr std::size_t kHead = 24;  // magic, version, 0, size of the body
constexpr std::size_t kTail = 8;   // checksum of the body

std::string ReadBytes(const fs::path& path) {
  std::ifstream stream(path, std::ios::binary);
  return {std::istreambuf_iterator<char>(stream), {}};
}

std::string BodyOf(const std::string& map) {
  return map.substr(kHead, map.size() - kHead - kTail);
}

/// The file of `body`, with the head of `map`.
std::string WithBody(const std::string& map, const std::string& body) {
  const std::uint64_t size = body.size();
  const std::uint64_t hash = Hash64(body);
  std::string file = map.substr(0, kHead) + body + std::string(kTail, '\0');
  std::memcpy(file.data() + kHead - sizeof(size), &size, sizeof(size));
  std::memcpy(file.data() + kHead + body.size(), &hash, sizeof(hash));
  return file;
}

/// Where the places' words begin in a map's body.
std::size_t WordsOf(const std::string& body) {
  const LoopCloserOptions options = test::FlightOptions();
  const PlaceFinder finder(
      options.place, options.scoring, options.candidates, test::FlightVocabulary());
  const std::uint64_t identity = finder.words_identity();
  std::string bytes(sizeof(identity), '\0');
  std::memcpy(bytes.data(), &identity, sizeof(identity));
  return body.rfind(bytes);
}

/// A map as version 3 had it.
std::string WithoutWords(const std::string& map) {
  const std::string body = BodyOf(map);
  std::string old = WithBody(map, body.substr(0, WordsOf(body)));
  old[8] = 3;
  return old;
}

/// Of a list of entries of `size` bytes, with its own length.
std::size_t LengthAt(const std::string& body, std::size_t at, std::size_t size) {
  std::uint64_t count = 0;
  std::memcpy(&count, &body[at], sizeof(count));
  return sizeof(count) + count * size;
}

/// A map whose places have words without weight.
std::string WithForgedWords(const std::string& map) {
  std::string body = BodyOf(map);
  std::size_t at = WordsOf(body) + sizeof(std::uint64_t);
  while (at < body.size()) {
    // Words and counts stay.
    at += LengthAt(body, at, sizeof(WordId));
    at += LengthAt(body, at, sizeof(std::uint16_t));
    const std::size_t length = LengthAt(body, at, sizeof(float));
    std::fill_n(&body[at + sizeof(std::uint64_t)], length - sizeof(std::uint64_t), '\0');
    at += length;
  }
  return WithBody(map, body);
}

class MapIo : public testing::Test {
 protected:
  MapIo()
      : directory_(fs::path(testing::TempDir()) /
                   (std::string("deja_view_map_") +
                    testing::UnitTest::GetInstance()->current_test_info()->name())) {
    fs::remove_all(directory_);
  }
  ~MapIo() override { fs::remove_all(directory_); }

  fs::path file() const { return directory_ / "map.dvm"; }

  void WriteMap(const std::string& bytes) const {
    fs::create_directories(directory_);
    std::ofstream(file(), std::ios::binary) << bytes;
  }

  /// Loading fails, says which file and why, and `closer` keeps what it had.
  void ExpectRefused(const std::string& bytes, const std::string& why, LoopCloser* closer) const {
    WriteMap(bytes);
    const int count = closer->keyframe_count();
    const int places = closer->place_count();
    try {
      closer->Load(directory_);
      ADD_FAILURE() << "no exception: " << why;
    } catch (const InputError& e) {
      const std::string what = e.what();
      EXPECT_NE(what.find(file().string()), std::string::npos) << what;
      EXPECT_NE(what.find(why), std::string::npos) << what;
    }
    EXPECT_EQ(closer->keyframe_count(), count);
    EXPECT_EQ(closer->place_count(), places);
  }

  /// The whole first session, solved.
  static const LoopCloser& FirstSession() {
    static const LoopCloser session = [] {
      LoopCloser closer = MakeCloser(1);
      for (const KeyframeInput& keyframe : SmallFlight(1).keyframes) {
        closer.AddKeyframe(keyframe);
      }
      closer.OptimizeFully();
      return closer;
    }();
    return session;
  }

  /// A map of two keyframes, some 100 kB.
  std::string SmallMap() const {
    LoopCloser closer = MakeCloser(1);
    closer.AddKeyframe(SmallFlight(1).keyframes[0]);
    closer.AddKeyframe(SmallFlight(1).keyframes[1]);
    closer.Save(directory_);
    return ReadBytes(file());
  }

  static LoopCloser WithOneKeyframe() {
    LoopCloser closer = MakeCloser(1);
    closer.AddKeyframe(SmallFlight(1).keyframes[5]);
    return closer;
  }

  fs::path directory_;
};

TEST_F(MapIo, LoadsWhatItSaved) {
  FirstSession().Save(directory_);
  LoopCloser loaded = WithOneKeyframe();
  loaded.Load(directory_);
  ASSERT_EQ(loaded.keyframe_count(), FirstSession().keyframe_count());
  EXPECT_EQ(loaded.place_count(), FirstSession().place_count());
  EXPECT_EQ(loaded.sequence_count(), 1);
  for (int i = 0; i < loaded.keyframe_count(); ++i) {
    const KeyframeInfo a = FirstSession().keyframe(i);
    const KeyframeInfo b = loaded.keyframe(i);
    EXPECT_EQ(a.stamp_ns, b.stamp_ns);
    EXPECT_EQ(a.sequence, b.sequence);
    EXPECT_EQ(a.T_W_B.t, b.T_W_B.t);
    EXPECT_EQ(a.T_M_B.t, b.T_M_B.t);
    EXPECT_EQ(a.T_M_B.q.coeffs(), b.T_M_B.q.coeffs());
  }
  const auto a = FirstSession().accepted_loops();
  const auto b = loaded.accepted_loops();
  ASSERT_EQ(a.size(), b.size());
  for (std::size_t i = 0; i < a.size(); ++i) {
    EXPECT_EQ(a[i].old, b[i].old);
    EXPECT_EQ(a[i].current, b[i].current);
    EXPECT_EQ(a[i].stamp_old_ns, b[i].stamp_old_ns);
    EXPECT_EQ(a[i].stamp_current_ns, b[i].stamp_current_ns);
    EXPECT_EQ(a[i].T_Bold_Bcurrent.t, b[i].T_Bold_Bcurrent.t);
    EXPECT_EQ(a[i].covariance, b[i].covariance);
    EXPECT_EQ(a[i].inliers, b[i].inliers);
    EXPECT_TRUE(b[i].accepted());
  }
  const std::string saved = ReadBytes(file());
  loaded.Save(directory_);
  EXPECT_EQ(ReadBytes(file()), saved) << "saving it again changes the file";
}

TEST_F(MapIo, ASecondSessionJoinsTheMap) {
  FirstSession().Save(directory_);
  // Walls of this hall share pictures; with own corners, too, so short a flight does not tell the
  // copies apart, and waits.
  LoopCloserOptions options = test::FlightOptions();
  options.motion_stereo.recent = 0;
  LoopCloser closer = MakeCloser(2, options);
  closer.Load(directory_);
  EXPECT_EQ(closer.drift().t, Eigen::Vector3d::Zero());
  const int first = closer.keyframe_count();
  for (const KeyframeInput& keyframe : SmallFlight(2).keyframes) {
    const KeyframeReport report = closer.AddKeyframe(keyframe);
    EXPECT_EQ(report.sequence, 1);
    EXPECT_EQ(report.is_new_sequence, report.index == first);
  }
  closer.OptimizeFully();
  ASSERT_TRUE(closer.is_joined(1));
  for (int i = 0; i < first; ++i) {
    EXPECT_EQ(closer.keyframe(i).T_M_B.t, FirstSession().keyframe(i).T_M_B.t) << "the map moved";
  }
  // The map's frame differs from the truth's by the first pose of the first session.
  const Rigid3 T_M_truth = closer.keyframe(0).T_M_B * SmallFlight(1).T_W_B.front().Inverse();
  double squared = 0;
  for (int i = first; i < closer.keyframe_count(); ++i) {
    const auto k = static_cast<std::size_t>(i - first);
    squared += (closer.keyframe(i).T_M_B.t - T_M_truth * SmallFlight(2).T_W_B[k].t).squaredNorm();
  }
  EXPECT_LT(std::sqrt(squared / (closer.keyframe_count() - first)), 0.6);
}

TEST_F(MapIo, AnEmptyMapIsAMapToo) {
  MakeCloser(1).Save(directory_);
  LoopCloser closer = WithOneKeyframe();
  closer.Load(directory_);
  EXPECT_EQ(closer.keyframe_count(), 0);
  EXPECT_EQ(closer.sequence_count(), 0);
  closer.OptimizeFully();
  EXPECT_EQ(closer.AddKeyframe(SmallFlight(1).keyframes[0]).sequence, 0);
}

TEST_F(MapIo, NoticesEveryChangedByteOfTheHead) {
  const std::string map = SmallMap();
  LoopCloser closer = WithOneKeyframe();
  for (std::size_t i = 0; i < kHead; ++i) {
    std::string damaged = map;
    damaged[i] = static_cast<char>(damaged[i] ^ 0x20);
    ExpectRefused(damaged, i < 8 ? "is not" : i < 16 ? "version" : "bytes of content", &closer);
  }
}

TEST_F(MapIo, NoticesChangedBytesOfTheBody) {
  const std::string map = SmallMap();
  LoopCloser closer = WithOneKeyframe();
  for (std::size_t i = kHead; i < map.size(); i += 997) {
    std::string damaged = map;
    damaged[i] = static_cast<char>(damaged[i] ^ 0x01);
    ExpectRefused(damaged, "checksum", &closer);
  }
}

TEST_F(MapIo, NoticesAFileThatIsCutOrTooLong) {
  const std::string map = SmallMap();
  const std::string body = BodyOf(map);
  ASSERT_EQ(WithBody(map, body), map) << "the test knows the format";
  LoopCloser closer = WithOneKeyframe();
  for (std::size_t size = 0; size < kHead + kTail; ++size) {
    ExpectRefused(map.substr(0, size), "too few", &closer);
  }
  for (std::size_t size = 0; size < body.size(); size += 1009) {
    ExpectRefused(map.substr(0, kHead + kTail + size), "bytes of content", &closer);
    ExpectRefused(WithBody(map, body.substr(0, size)), "(at byte ", &closer);
  }
  ExpectRefused(map + '\0', "bytes of content", &closer);
  ExpectRefused(WithBody(map, body + '\0'), "bytes too many", &closer);
}

TEST_F(MapIo, SurvivesForgedFiles) {
  const std::string map = SmallMap();
  const std::string body = BodyOf(map);
  std::mt19937 rng(1);
  int refused = 0;
  for (int run = 0; run < 150; ++run) {
    // The first bytes hold counts and poses, the last words, the rest mostly descriptors.
    const std::size_t range = run % 3 == 0 ? body.size() : 256;
    const std::size_t at = rng() % range;
    std::string forged = body;
    forged[run % 3 == 1 ? body.size() - 1 - at : at] = static_cast<char>(rng() % 256);
    WriteMap(WithBody(map, forged));
    LoopCloser closer = MakeCloser(1);
    try {
      closer.Load(directory_);
      EXPECT_LE(closer.keyframe_count(), 2);
    } catch (const InputError& e) {
      ++refused;
      EXPECT_NE(std::string(e.what()).find(file().string()), std::string::npos) << e.what();
    }
  }
  EXPECT_GT(refused, 10);
}

TEST_F(MapIo, RefusesAnotherCamerasMap) {
  const std::string map = SmallMap();
  const sim::RecordedFlight& flight = SmallFlight(1);
  LoopCloser other(test::FlightOptions(),
                   std::shared_ptr<const Camera>(flight.camera->Scaled(0.5)),
                   flight.T_B_C,
                   test::FlightVocabulary());
  ExpectRefused(map, "image size", &other);
}

TEST_F(MapIo, KeepsThePlacesWords) {
  const std::string map = SmallMap();
  const KeyframeInput& keyframe = SmallFlight(1).keyframes[1];
  const auto score = [&](const std::string& bytes, const LoopCloserOptions& options) {
    WriteMap(bytes);
    LoopCloser closer = MakeCloser(1, options);
    closer.Load(directory_);
    const KeyframeReport report = closer.AddKeyframe(keyframe);
    return report.best_place ? report.best_place->score : 0.0;
  };
  const LoopCloserOptions same = test::FlightOptions();
  EXPECT_GT(score(map, same), 0.5);
  EXPECT_EQ(score(WithoutWords(map), same), score(map, same)) << "looked up";
  EXPECT_EQ(score(WithForgedWords(map), same), 0.0) << "not looked up";
  LoopCloserOptions other = same;
  other.scoring.synonym_radius = 20;
  EXPECT_EQ(score(WithForgedWords(map), other), score(WithoutWords(map), other));
  other.scoring.is_on = false;
  EXPECT_EQ(score(WithForgedWords(map), other), score(WithoutWords(map), other));
}

TEST_F(MapIo, RefusesWordsThatCannotBe) {
  const std::string map = SmallMap();
  const std::string body = BodyOf(map);
  LoopCloser closer = WithOneKeyframe();
  const auto refuse = [&](std::size_t at, auto value, const std::string& why) {
    std::string forged = body;
    std::memcpy(&forged[at], &value, sizeof(value));
    ExpectRefused(WithBody(map, forged), why, &closer);
  };
  const std::size_t words = WordsOf(body) + sizeof(std::uint64_t);
  const std::size_t counts = words + LengthAt(body, words, sizeof(WordId));
  const std::size_t weights = counts + LengthAt(body, counts, sizeof(std::uint16_t));
  constexpr std::size_t kFirst = sizeof(std::uint64_t);
  refuse(words + kFirst, std::uint32_t{0xffffff}, "words: not of the vocabulary");
  refuse(words + kFirst + sizeof(WordId), std::uint32_t{0}, "words: not of the");
  refuse(counts + kFirst, std::uint16_t{0}, "words: not of the vocabulary");
  refuse(counts + kFirst, std::uint16_t{999}, "word counts: not those of the descriptors");
  refuse(weights + kFirst, -0.5F, "word weights: not those");
  refuse(weights + kFirst, NAN, "word weights: not those");
  refuse(weights, std::uint64_t{0}, "words: lists of different lengths");
}

TEST_F(MapIo, NamesAMissingMap) {
  LoopCloser closer = WithOneKeyframe();
  try {
    closer.Load(directory_);
    FAIL() << "no exception";
  } catch (const InputError& e) {
    EXPECT_NE(std::string(e.what()).find(file().string()), std::string::npos) << e.what();
  }
  EXPECT_EQ(closer.keyframe_count(), 1);
}

/// No file of this process can grow beyond `bytes`: a full disk.
class FileSizeLimit {
 public:
  explicit FileSizeLimit(rlim_t bytes) : handler_(std::signal(SIGXFSZ, SIG_IGN)) {
    getrlimit(RLIMIT_FSIZE, &before_);
    const rlimit limit{bytes, before_.rlim_max};
    setrlimit(RLIMIT_FSIZE, &limit);
  }
  ~FileSizeLimit() {
    setrlimit(RLIMIT_FSIZE, &before_);
    std::signal(SIGXFSZ, handler_);
  }
  FileSizeLimit(const FileSizeLimit&) = delete;
  FileSizeLimit& operator=(const FileSizeLimit&) = delete;

 private:
  void (*handler_)(int);
  rlimit before_{};
};

TEST_F(MapIo, AFailedSaveLeavesTheOldMap) {
  const std::string before = SmallMap();
  std::string what;
  {
    const FileSizeLimit limit(before.size() / 2);
    try {
      FirstSession().Save(directory_);
    } catch (const InputError& e) {
      what = e.what();
    }
  }
  EXPECT_NE(what.find(file().string()), std::string::npos) << what;
  EXPECT_EQ(ReadBytes(file()), before);
  EXPECT_EQ(std::distance(fs::directory_iterator(directory_), fs::directory_iterator()), 1);
}

TEST_F(MapIo, CannotSaveWhereAFileIsInTheWay) {
  std::ofstream(directory_) << "in the way";
  EXPECT_THROW(FirstSession().Save(directory_), InputError);
  EXPECT_EQ(ReadBytes(directory_), "in the way");
}

}  // namespace
}  // namespace deja_view
