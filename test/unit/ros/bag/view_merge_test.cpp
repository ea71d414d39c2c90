#include "deja_view/ros/messages/virtual_frame_conversion.hpp"

#include <map>
#include <set>

#include "view_bag_fixture.hpp"
#include <gmock/gmock.h>

#include <std_msgs/String.h>

namespace deja_view {
namespace {

namespace fs = std::filesystem;

class SubMapTest : public ViewBagTest {
 protected:
  SubMapTest() { job_.sources = SourceKind::kImages; }

  // Images 0 and 1 are of sub-map 0, the four others of sub-map 1.
  ViewJob Job(Shard sub_map, Shard shard, const std::string& model) {
    ViewJob job = job_;
    job.shard = shard;
    job.sub_map.shard = sub_map;
    job.sub_map.is_own = [i = sub_map.index](const Eigen::Vector3d& p) {
      return (p.x() < -0.4) == (i == 0);
    };
    job.sub_map.settings = model;
    job.out = Path(fmt::format("part{}{}.bag", sub_map.index, shard.index));
    return job;
  }

  static std::map<std::int64_t, std::set<std::uint64_t>> Hashes(const fs::path& path) {
    std::map<std::int64_t, std::set<std::uint64_t>> hashes;
    BagReader(path).Read({ViewTopics().frame}, [&](const rosbag::MessageInstance& m) {
      const VirtualView view = FromVirtualFrame(*Instantiate<VirtualFrame>(m), m.getTopic());
      hashes[view.stamp_ns].insert(view.settings_hash);
    });
    return hashes;
  }
};

TEST_F(SubMapTest, PartsOfSubMapsGiveEveryImageItsViewsOnce) {
  Run(job_);
  const ViewReport first = Run(Job({0, 2}, {0, 1}, "model: a"));
  const ViewReport second = Run(Job({1, 2}, {0, 1}, "model: b"));
  EXPECT_EQ(first.sources, 2);
  EXPECT_EQ(second.sources, 4);
  const fs::path merged = Path("merged.bag");
  EXPECT_EQ(MergeViews(*job_.flight, {Path("part10.bag"), Path("part00.bag")}, merged).views, 12);
  EXPECT_TRUE(ReadMessages(merged, false) == ReadMessages(job_.flight->path(), false));
  // The same views as of one model, but for what says which one made them.
  const auto hashes = Hashes(merged);
  ASSERT_EQ(hashes.size(), 6U);
  EXPECT_EQ(hashes.at(Stamp(0)), hashes.at(Stamp(1)));
  EXPECT_EQ(hashes.at(Stamp(2)), hashes.at(Stamp(5)));
  EXPECT_NE(hashes.at(Stamp(1)), hashes.at(Stamp(2)));
  EXPECT_EQ(ReadMessages(merged, true).size(), ReadMessages(job_.out, true).size());
  BagReader(merged).Read({ViewTopics().settings}, [](const rosbag::MessageInstance& m) {
    EXPECT_EQ(Instantiate<std_msgs::String>(m)->data,
              "# sub-map 0 of 2: model: a\n# sub-map 1 of 2: model: b\nroom\n");
  });
}

TEST_F(SubMapTest, SharesOfSubMapsMergeToTheSameFile) {
  std::vector<fs::path> halves;
  std::vector<fs::path> wholes;
  for (int sub_map = 0; sub_map < 2; ++sub_map) {
    const std::string model = "model: " + std::to_string(sub_map);
    for (int i = 0; i < 2; ++i) {
      const ViewJob job = Job({sub_map, 2}, {i, 2}, model);
      EXPECT_EQ(Run(job).sources, 1 + sub_map);
      halves.push_back(job.out);
    }
    ViewJob job = Job({sub_map, 2}, {0, 1}, model);
    job.out = Path("whole" + std::to_string(sub_map));
    Run(job);
    wholes.push_back(job.out);
  }
  MergeViews(*job_.flight, {halves[3], halves[0], halves[2], halves[1]}, Path("halves.bag"));
  MergeViews(*job_.flight, wholes, Path("wholes.bag"));
  EXPECT_EQ(Bytes(Path("halves.bag")), Bytes(Path("wholes.bag")));
  EXPECT_THAT(ErrorOf([&] {
                MergeViews(*job_.flight, {halves[0], halves[1], halves[2]}, Path("x.bag"));
              }),
              Says("part 1 of 2 of sub-map 1 of 2 is missing"));
  EXPECT_THAT(ErrorOf([&] {
                MergeViews(*job_.flight, {halves[0], wholes[1]}, Path("x.bag"));
              }),
              Says("another number of parts"));
}

TEST_F(SubMapTest, RefusesPartsThatDoNotBelongTogether) {
  Run(Job({0, 2}, {0, 1}, "model: a"));
  Run(Job({1, 2}, {0, 1}, "model: b"));
  const std::vector<fs::path> parts = {Path("part00.bag"), Path("part10.bag")};
  const fs::path out = Path("x.bag");
  EXPECT_THAT(ErrorOf([&] { MergeViews(*job_.flight, {parts[0]}, out); }),
              Says("part 0 of 1 of sub-map 1 of 2 is missing"));
  EXPECT_THAT(ErrorOf([&] {
                MergeViews(*job_.flight, {parts[0], parts[0], parts[1]}, out);
              }),
              Says("part 0 of 1 of sub-map 0 of 2 is given twice"));
  ViewJob other = Job({1, 3}, {0, 1}, "model: b");
  other.out = Path("of_three.bag");
  Run(other);
  EXPECT_THAT(ErrorOf([&] {
                MergeViews(*job_.flight, {parts[0], other.out}, out);
              }),
              Says("of_three.bag"));
  // Two shares of a sub-map by different models.
  ViewJob half = Job({0, 2}, {0, 2}, "model: a");
  Run(half);
  ViewJob half_of_other = Job({0, 2}, {1, 2}, "model: c");
  Run(half_of_other);
  EXPECT_THAT(ErrorOf([&] {
                MergeViews(*job_.flight, {half.out, half_of_other.out}, out);
              }),
              Says("other settings"));
  EXPECT_FALSE(fs::exists(out));
}

TEST_F(SubMapTest, ResumesOnlyWhatTheSameModelMade) {
  job_.threads = 1;
  interrupt_at_ = 1;
  EXPECT_THROW(Run(Job({1, 2}, {0, 1}, "model: b")), std::runtime_error);
  interrupt_at_ = 1000;
  EXPECT_EQ(Run(Job({1, 2}, {0, 1}, "model: c")).resumed, 0);
  interrupt_at_ = 1;
  EXPECT_THROW(Run(Job({1, 2}, {0, 1}, "model: b")), std::runtime_error);
  interrupt_at_ = 1000;
  EXPECT_EQ(Run(Job({1, 2}, {0, 1}, "model: b")).resumed, 1);
}

TEST_F(SubMapTest, ASubMapThatTheFlightDoesNotVisitGivesAnEmptyPart) {
  ViewJob first = Job({0, 2}, {0, 1}, "model: a");
  ViewJob second = Job({1, 2}, {0, 1}, "model: b");
  first.sub_map.is_own = [](const Eigen::Vector3d&) { return true; };
  second.sub_map.is_own = [](const Eigen::Vector3d&) { return false; };
  Run(first);
  EXPECT_EQ(Run(second).sources, 0);
  EXPECT_EQ(MergeViews(*job_.flight, {first.out, second.out}, Path("merged.bag")).views, 12);
}

}  // namespace
}  // namespace deja_view
