#include "deja_view/base/check.hpp"
#include "deja_view/base/random.hpp"
#include "deja_view/camera/camera_parameters.hpp"
#include "deja_view/nerf/device.hpp"
#include "deja_view/nerf/field_renderer.hpp"
#include "deja_view/nerf/trainer.hpp"

#include <algorithm>
#include <memory>

#include "device_batches.hpp"
#include "device_engine.hpp"
#include "host_platform.hpp"
#include "nerf/closed_form.hpp"
#include "nerf/wave_room.hpp"
#include <gmock/gmock.h>
#include <opencv2/core.hpp>

namespace deja_view::nerf::internal {
namespace {

using testing::HasSubstr;

const DeviceChoice kCard{&Host(), 0};

/// A machine as it is reported.
class FakeMachine : public DevicePlatform {
 public:
  explicit FakeMachine(DeviceReport report) : report_(std::move(report)) {}
  DeviceReport Find() const override { return report_; }
  std::unique_ptr<DeviceEngine> Open(int card) const override { return Host().Open(card); }

 private:
  DeviceReport report_;
};

DeviceReport WithCards(const std::vector<int>& numbers) {
  DeviceReport report;
  for (const int number : numbers) {
    report.cards.push_back({number, "card " + std::to_string(number), 8, 0, 0});
  }
  report.runtime = "13.0";
  return report;
}

DeviceReport WithProblem(const std::string& problem, const std::string& runtime) {
  DeviceReport report;
  report.problem = problem;
  report.runtime = runtime;
  return report;
}

template <typename Call>
std::string InputErrorOf(const Call& call) {
  try {
    call();
  } catch (const InputError& e) {
    return e.what();
  }
  return "no error";
}

TEST(ChooseDevice, AutoTakesTheFirstCardThatCanBeUsed) {
  const FakeMachine machine(WithCards({1, 3}));
  const ChosenDevice chosen = ChooseDevice("auto", machine);
  EXPECT_FALSE(chosen.device.IsCpu());
  EXPECT_EQ(chosen.device.card, 1);
  EXPECT_THAT(chosen.note, HasSubstr("card 1"));
}

TEST(ChooseDevice, AutoFallsBackToTheCpuAndTellsWhy) {
  for (const char* problem : {"no driver of a graphics card", "the driver is too old"}) {
    const ChosenDevice chosen = ChooseDevice("auto", FakeMachine(WithProblem(problem, "13.0")));
    EXPECT_TRUE(chosen.device.IsCpu());
    EXPECT_THAT(chosen.note, HasSubstr(problem));
    EXPECT_THAT(chosen.note, HasSubstr("CPU"));
  }
}

TEST(ChooseDevice, BuildsWithoutCudaSayNothingOnTheirOwn) {
  const FakeMachine machine(WithProblem("this build has no CUDA", ""));
  EXPECT_EQ(ChooseDevice("auto", machine).note, "");
  EXPECT_TRUE(ChooseDevice("auto", machine).device.IsCpu());
  EXPECT_THAT(InputErrorOf([&] { ChooseDevice("cuda", machine); }),
              HasSubstr("this build has no CUDA"));
}

TEST(ChooseDevice, TakesTheNamedOne) {
  const FakeMachine machine(WithCards({0, 2}));
  EXPECT_TRUE(ChooseDevice("cpu", machine).device.IsCpu());
  EXPECT_EQ(ChooseDevice("cuda", machine).device.card, 0);
  EXPECT_EQ(ChooseDevice("cuda:2", machine).device.card, 2);
  EXPECT_EQ(ChooseDevice("cuda:2", machine).note, "");
  EXPECT_THAT(InputErrorOf([&] { ChooseDevice("cuda:1", machine); }), HasSubstr("0, 2"));
  for (const char* name : {"gpu", "cuda:", "cuda:x", "cuda:-1", "cuda:0x", "CUDA", ""}) {
    EXPECT_THAT(InputErrorOf([&] { ChooseDevice(name, machine); }), HasSubstr("auto, cpu, cuda"))
        << name;
  }
}

class DeviceFailuresTest : public testing::Test {
 protected:
  void TearDown() override { HealHost(); }

  static RadianceField OpaqueField() {
    RadianceField field = ConstantField(20, 0.3F);
    field.march = MarchOptions();
    return field;
  }

  /// No two pixels of its views need be the same.
  static RadianceField StripedField() {
    RadianceField field(SmallFieldOptions(), MarchOptions(), OpaqueField().box, 1, 5);
    Random random(2);
    for (FeatureGrid* grid : {&field.geometry, &field.appearance}) {
      for (std::size_t i = 0; i < grid->parameters().size(); ++i) {
        grid->parameters()[i] = 4 * random.UniformFloat() - 2;
      }
    }
    return field;
  }

  std::shared_ptr<const Camera> camera_ =
      MakeCamera({"PINHOLE", 64, 48, {0, 0, 0, 0}, {40, 40, 32, 24}}, "test");
};

TEST_F(DeviceFailuresTest, LittleMemoryMeansFewerRaysAtATime) {
  const auto field = std::make_shared<RadianceField>(StripedField());
  RenderedView expected;
  std::size_t plenty = 0;
  {
    const FieldRenderer renderer(field, kCard);
    expected = renderer.Render(*camera_, {}, {});
    plenty = HostBytes();
  }
  ASSERT_EQ(HostBytes(), std::size_t{0});
  SetHostMemory(plenty / 2);
  const FieldRenderer renderer(field, kCard);
  const RenderedView view = renderer.Render(*camera_, {}, {});
  EXPECT_EQ(cv::norm(view.image, expected.image, cv::NORM_INF), 0);
  EXPECT_EQ(cv::norm(view.depth, expected.depth, cv::NORM_INF), 0);
  EXPECT_GT(cv::norm(view.image.row(0), view.image.row(24), cv::NORM_INF), 10);
}

TEST_F(DeviceFailuresTest, TooLittleMemoryIsToldWithWhatIsNeeded) {
  const auto field = std::make_shared<RadianceField>(OpaqueField());
  SetHostMemory(10000);
  try {
    const FieldRenderer renderer(field, kCard);
    FAIL() << "expected a DeviceMemoryError";
  } catch (const DeviceMemoryError& e) {
    EXPECT_THAT(e.what(), HasSubstr("a stand-in"));
    EXPECT_THAT(e.what(), HasSubstr("MB free"));
  }
}

TEST_F(DeviceFailuresTest, TrainingWithLittleMemoryTakesTheSameRays) {
  TrainOptions options = SmallOptions();
  options.target_samples = 1 << 17;
  options.warmup_steps = 2;
  std::vector<double> psnr_db;
  std::size_t plenty = 0;
  std::size_t start = 0;
  for (const bool is_little : {false, true}) {
    Trainer trainer(options, MakeViews(4), RoomBox(), kCard);
    start = HostBytes();
    if (is_little) {
      SetHostMemory(start + (plenty - start) / 2);
    }
    StepReport report;
    for (int i = 0; i < 12; ++i) {
      report = trainer.Step(0);
    }
    plenty = std::max(plenty, HostBytes());
    psnr_db.push_back(report.psnr_db);
    EXPECT_GT(report.rays, 2 * DeviceBatches::kLeast);
  }
  EXPECT_NEAR(psnr_db[0], psnr_db[1], 0.02);
}

// What was fetched before the card was lost is there, and whole; nothing else passes for a field.
TEST_F(DeviceFailuresTest, ALostCardEndsTrainingWithTheLastFetchedField) {
  Trainer trainer(SmallOptions(), MakeViews(4), RoomBox(), kCard);
  for (int i = 0; i < 3; ++i) {
    trainer.Step(0.1 * i);
  }
  const std::vector<float> fetched = trainer.field().color.parameters();
  LoseHostAfter(4);
  EXPECT_THROW(
      {
        for (int i = 0; i < 9; ++i) {
          trainer.Step(0.5);
        }
      },
      DeviceLostError);
  EXPECT_THROW(trainer.field(), DeviceLostError);
  EXPECT_THROW(trainer.Step(0.5), DeviceLostError);
}

TEST_F(DeviceFailuresTest, ALostCardGivesNoPicture) {
  const auto field = std::make_shared<RadianceField>(OpaqueField());
  const FieldRenderer renderer(field, kCard);
  LoseHostAfter(1);
  renderer.Render(*MakeCamera({"PINHOLE", 4, 3, {0, 0, 0, 0}, {2, 2, 2, 1}}, "test"), {}, {});
  EXPECT_THROW(renderer.Render(*camera_, {}, {}), DeviceLostError);
}

/// A card that computes wrongly what a field looks like.
class WrongCard : public DevicePlatform {
 public:
  DeviceReport Find() const override { return WithCards({0}); }
  std::unique_ptr<DeviceEngine> Open(int card) const override;
};

class WrongEngine final : public DeviceEngine {
 public:
  explicit WrongEngine(std::unique_ptr<DeviceEngine> engine) : engine_(std::move(engine)) {}
  std::string Name() const override { return "a wrong card"; }
  std::size_t PeakBytes() const override { return engine_->PeakBytes(); }
  void LoadField(const FieldLayout& layout, const ConstArrays& values) override {
    engine_->LoadField(layout, values);
  }
  void SaveField(const Arrays& values) override { engine_->SaveField(values); }
  void Render(const RenderJob& job,
              std::size_t first,
              std::size_t count,
              const PixelArrays& out) override {
    engine_->Render(job, first, count, out);
    for (std::size_t i = 0; i < count; i += 20) {
      out.image[i] = static_cast<std::uint8_t>(out.image[i] + 3);
    }
  }
  void StartTraining(const TrainOptions& options,
                     const TrainingSet& set,
                     const std::vector<std::uint64_t>& open) override {
    engine_->StartTraining(options, set, open);
  }
  void SetImages(const ImageState& state) override { engine_->SetImages(state); }
  StepSums AddRays(const StepPlan& plan,
                   std::size_t first,
                   std::size_t count,
                   RayGradients* out) override {
    return engine_->AddRays(plan, first, count, out);
  }
  void DropGradients() override { engine_->DropGradients(); }
  void UpdateField(float rate) override { engine_->UpdateField(rate); }
  void UpdateOccupancy(std::uint64_t round, bool full) override {
    engine_->UpdateOccupancy(round, full);
  }

 private:
  std::unique_ptr<DeviceEngine> engine_;
};

std::unique_ptr<DeviceEngine> WrongCard::Open(int card) const {
  return std::make_unique<WrongEngine>(Host().Open(card));
}

TEST_F(DeviceFailuresTest, ACardThatComputesWronglyIsNotUsed) {
  const auto field = std::make_shared<RadianceField>(OpaqueField());
  const WrongCard wrong;
  try {
    const FieldRenderer renderer(field, DeviceChoice{&wrong, 0});
    FAIL() << "expected a DeviceError";
  } catch (const DeviceError& e) {
    EXPECT_THAT(e.what(), HasSubstr("a wrong card"));
    EXPECT_THAT(e.what(), HasSubstr("not what the CPU shows"));
  }
  EXPECT_THROW(Trainer(SmallOptions(), MakeViews(2), RoomBox(), DeviceChoice{&wrong, 0}),
               DeviceError);
}

}  // namespace
}  // namespace deja_view::nerf::internal
