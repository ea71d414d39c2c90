#include "deja_view/lab/report/matches.hpp"

#include "deja_view/base/check.hpp"

#include <filesystem>
#include <fstream>

#include "count_of.hpp"
#include <gtest/gtest.h>

namespace deja_view::report {
namespace {

namespace fs = std::filesystem;

constexpr const char* kMatchesHeader =
    "stamp_current_ns,stamp_old_ns,virtual,view,u_old,v_old,u_current,v_current\n";

MatchedLoop Loop(std::int64_t stamp_ns, const std::vector<int>& views) {
  MatchedLoop loop;
  loop.stamp_current_ns = stamp_ns;
  loop.stamp_old_ns = 1'000'000'000;
  for (const int view : views) {
    loop.pairs.push_back({view, {100, 50}, {200, 60}});
  }
  return loop;
}

std::vector<MatchedLoop> Read(const std::string& content) {
  const fs::path path = fs::path(testing::TempDir()) / "deja_view_matches.csv";
  std::ofstream(path) << content;
  try {
    auto loops = ReadMatches(path);
    fs::remove(path);
    return loops;
  } catch (...) {
    fs::remove(path);
    throw;
  }
}

TEST(Matches, AreReadLoopByLoop) {
  const auto loops = Read(std::string(kMatchesHeader) +
                          "30,10,0,-1,1.5,2,3,4\n30,10,0,-1,5,6,7,8\n40,10,1,2,1,2,3,4.5\n");
  ASSERT_EQ(loops.size(), 2U);
  EXPECT_EQ(loops[0].pairs.size(), 2U);
  EXPECT_EQ(loops[0].stamp_current_ns, 30);
  EXPECT_EQ(loops[0].pairs[0].old_pixel, Point(1.5, 2));
  EXPECT_FALSE(loops[0].is_virtual);
  EXPECT_TRUE(loops[1].is_virtual);
  EXPECT_EQ(loops[1].BestView(), 2);
  EXPECT_EQ(loops[1].pairs[0].current_pixel, Point(3, 4.5));
  EXPECT_TRUE(Read(kMatchesHeader).empty());
}

TEST(Matches, BadFilesAreRefusedWithTheirLine) {
  EXPECT_THROW(Read("u,v\n"), InputError);
  try {
    Read(std::string(kMatchesHeader) + "30,10,0,-1,1,2,3,4\n30,10,0\n");
    ADD_FAILURE();
  } catch (const InputError& e) {
    EXPECT_NE(std::string(e.what()).find(":3: "), std::string::npos) << e.what();
  }
}

TEST(Matches, TheBestViewHasMostInliers) {
  const MatchedLoop loop = Loop(5, {-1, -1, -1, 3, 1, 1});
  EXPECT_EQ(loop.CountIn(-1), 3);
  EXPECT_EQ(loop.BestView(), 1);
  EXPECT_EQ(Loop(5, {-1}).BestView(), -1);
  const auto pictures = PicturesOf(loop);
  ASSERT_EQ(pictures.size(), 3U);
  EXPECT_EQ(pictures[2], std::make_pair(std::int64_t{1'000'000'000}, 1));
}

TEST(Matches, LoopsWithViewsAreChosenFirst) {
  std::vector<MatchedLoop> loops;
  for (int i = 0; i < 6; ++i) {
    loops.push_back(Loop(2 * i, {-1}));
    loops.push_back(Loop(2 * i + 1, {-1, 0}));
  }
  const auto chosen = ChooseMatches(loops, 4);
  ASSERT_EQ(chosen.size(), 4U);
  int with_views = 0;
  for (std::size_t i = 0; i < chosen.size(); ++i) {
    with_views += chosen[i].BestView() >= 0 ? 1 : 0;
    EXPECT_TRUE(i == 0 || chosen[i - 1].stamp_current_ns <= chosen[i].stamp_current_ns);
  }
  EXPECT_EQ(with_views, 3);
  EXPECT_EQ(ChooseMatches({loops[0], loops[2]}, 4).size(), 2U);
  EXPECT_EQ(ChooseMatches({loops[1]}, 4).size(), 1U);
  EXPECT_TRUE(ChooseMatches({}, 4).empty());
}

TEST(Matches, TheFigureShowsImagesAndLines) {
  const MatchedLoop loop = Loop(3'000'000'000, {-1, -1, 0});
  Pictures pictures;
  pictures[{loop.stamp_current_ns, -1}] = {"\xff\xd8 now", 752, 480};
  pictures[{loop.stamp_old_ns, -1}] = {"\xff\xd8 then", 752, 480};
  const std::string svg = MatchFigure(loop, pictures, 1'000'000'000);
  // Real and virtual row; the current image is in both, the view's own picture is missing.
  EXPECT_EQ(CountOf(svg, "<image "), 3U);
  EXPECT_EQ(CountOf(svg, "<rect class=\"frame\""), 4U);
  EXPECT_NE(svg.find("At 2.0 s the place of 0.0 s is seen again: 3 inliers"), std::string::npos);
  EXPECT_NE(svg.find("the real image of the place, 2 inliers"), std::string::npos);
  EXPECT_NE(svg.find("virtual view 0 of the place, 1 inlier"), std::string::npos);
  EXPECT_EQ(CountOf(svg, "href=\""), CountOf(svg, "href=\"data:image/jpeg;base64,"));
}

TEST(Matches, PixelsAreScaledToTheirPicture) {
  // A picture of 530 px width is drawn as large as it is: pixel (99.5, 49.5) is 100 to the right.
  MatchedLoop loop = Loop(3'000'000'000, {-1});
  loop.pairs[0] = {-1, {99.5, 49.5}, {199.5, 59.5}};
  Pictures pictures;
  pictures[{loop.stamp_current_ns, -1}] = pictures[{loop.stamp_old_ns, -1}] = {"x", 530, 300};
  const std::string svg = MatchFigure(loop, pictures, 5'000'000'000);
  EXPECT_NE(svg.find("M100 84L750 94"), std::string::npos) << svg;
  EXPECT_NE(svg.find("an earlier flight"), std::string::npos);
}

}  // namespace
}  // namespace deja_view::report
