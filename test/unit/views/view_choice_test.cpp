#include "deja_view/views/view_choice.hpp"

#include "deja_view/camera/pinhole_camera.hpp"

#include <stdexcept>

#include "room_renderer.hpp"
#include <gmock/gmock.h>

namespace deja_view {
namespace {

using ::testing::ElementsAre;
using ::testing::HasSubstr;
using ::testing::IsEmpty;

const auto kChoiceCamera =
    std::make_shared<PinholeCamera>(PinholeParameters{160, 120, 100, 100, 79.5, 59.5, 0, 0, 0, 0});
constexpr std::int64_t kChoiceStamp = 1403636632538560256;

// A camera that looks along x, the room's z being up.
Rigid3 LookAlongX(double x, double y) {
  const Eigen::Matrix3d R =
      (Eigen::Matrix3d() << 0, 0, 1, -1, 0, 0, 0, -1, 0).finished();  // columns: right, down, ahead
  return {Eigen::Quaterniond(R), {x, y, 0}};
}

SamplingOptions Around(double radius_m) {
  SamplingOptions options;
  options.radius_m = radius_m;
  options.min_radius_m = 0.1;
  options.spacing_min_m = 0.2;
  options.spacing_max_m = 3;
  options.rotation_deg = 10;
  return options;
}

ChoiceOptions Need() {
  ChoiceOptions options;
  options.by = ChoiceKind::kNeed;
  options.reversed = false;
  return options;
}

GateOptions Gate() {
  GateOptions options;
  options.scale = 0.25;
  return options;
}

std::vector<ChosenViews> Choose(const ChoiceOptions& choice,
                                const SamplingOptions& sampling,
                                const std::vector<PlacedImage>& images,
                                int threads = 1,
                                const RoomRenderer& room = RoomRenderer()) {
  const ViewChooser chooser(choice, sampling, Gate(), kChoiceCamera, {});
  std::size_t last = 0;
  std::vector<ChosenViews> chosen =
      chooser.Choose(images, room, threads, [&](std::size_t done, std::size_t total) {
        EXPECT_EQ(total, 2 * images.size());
        EXPECT_THAT(done, testing::AllOf(testing::Ge(last), testing::Le(total)));
        last = done;
      });
  EXPECT_GE(last, images.size());
  return chosen;
}

std::size_t Count(const std::vector<ChosenViews>& chosen) {
  std::size_t count = 0;
  for (const ChosenViews& views : chosen) {
    count += views.T_C_V.size();
  }
  return count;
}

TEST(ViewChoiceTest, NoViewWhereThePhotographIsRecognised) {
  const std::vector<PlacedImage> image = {{kChoiceStamp, LookAlongX(-2, 0)}};
  EXPECT_EQ(Count(Choose(Need(), Around(0.3), image)), 0U);
  EXPECT_GT(Count(Choose(Need(), Around(2), image)), 0U);
}

TEST(ViewChoiceTest, ChoosesWhatThePhotographDoesNotShow) {
  ChoiceOptions choice = Need();
  choice.reversed = true;
  choice.views_per_image = 1;
  const Rigid3 T_N_C = LookAlongX(0, 0);
  const std::vector<ChosenViews> chosen = Choose(choice, Around(0.3), {{kChoiceStamp, T_N_C}});
  ASSERT_EQ(Count(chosen), 1U);
  const Rigid3 T_N_V = T_N_C * chosen[0].T_C_V[0];
  const Eigen::Vector3d ahead = T_N_V.q * Eigen::Vector3d::UnitZ();
  EXPECT_LT(ahead.x(), -0.9);                                                            // back
  EXPECT_GT((T_N_V.q * Eigen::Vector3d::UnitY()).dot(-Eigen::Vector3d::UnitZ()), 0.95);  // upright
}

TEST(ViewChoiceTest, AViewServesTheImagesBesideIt) {
  ChoiceOptions choice = Need();
  choice.reversed = true;
  choice.views_per_image = 100;
  const std::size_t of_one = Count(Choose(choice, Around(0.3), {{kChoiceStamp, LookAlongX(0, 0)}}));
  const std::size_t of_two =
      Count(Choose(choice,
                   Around(0.3),
                   {{kChoiceStamp, LookAlongX(0, 0)}, {kChoiceStamp + 1, LookAlongX(0.05, 0)}}));
  EXPECT_GE(of_one, 1U);
  EXPECT_LE(of_two, of_one + 1);
}

TEST(ViewChoiceTest, KeepsToTheBudgetAndIsTheSameOnAnyNumberOfThreads) {
  ChoiceOptions choice = Need();
  choice.views_per_image = 1.5;
  const std::vector<PlacedImage> images = {{kChoiceStamp, LookAlongX(-2, -1)},
                                           {kChoiceStamp + 7, LookAlongX(1, 1)}};
  const std::vector<ChosenViews> one = Choose(choice, Around(1.5), images, 1);
  const std::vector<ChosenViews> four = Choose(choice, Around(1.5), images, 4);
  ASSERT_EQ(Count(one), 3U);
  for (std::size_t i = 0; i < images.size(); ++i) {
    ASSERT_EQ(one[i].T_C_V.size(), four[i].T_C_V.size());
    for (std::size_t k = 0; k < one[i].T_C_V.size(); ++k) {
      EXPECT_EQ(one[i].T_C_V[k].t, four[i].T_C_V[k].t);
      EXPECT_EQ(one[i].T_C_V[k].q.coeffs(), four[i].T_C_V[k].q.coeffs());
    }
  }
}

TEST(ViewChoiceTest, CountsWhatTheGatePassedOver) {
  const std::vector<ChosenViews> unsure =
      Choose(Need(), Around(0.3), {{kChoiceStamp, LookAlongX(0, 0)}}, 1, RoomRenderer(0.2));
  EXPECT_THAT(unsure[0].T_C_V, IsEmpty());
  EXPECT_GT(unsure[0].not_free + unsure[0].uncertain, 0);
}

TEST(ViewChoiceTest, CanBeInterrupted) {
  const ViewChooser chooser(Need(), Around(0.3), Gate(), kChoiceCamera, {});
  EXPECT_THROW(chooser.Choose({{kChoiceStamp, LookAlongX(0, 0)}},
                              RoomRenderer(),
                              1,
                              [](std::size_t /*done*/, std::size_t /*total*/) {
                                throw std::runtime_error("interrupted");
                              }),
               std::runtime_error);
}

TEST(ViewChoiceTest, OptionsNameWhatIsWrong) {
  ChoiceOptions options;
  options.candidates = 0;
  options.enough = 0;
  options.look.zoom = 0.5;
  EXPECT_THAT(
      options.Validate(),
      ElementsAre(HasSubstr("candidates: 0"), HasSubstr("enough: 0"), HasSubstr("look.zoom: 0.5")));
}

}  // namespace
}  // namespace deja_view
