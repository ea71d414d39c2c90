#include "deja_view/views/view_queue.hpp"

#include <thread>

#include <gmock/gmock.h>

namespace deja_view {
namespace {

constexpr std::int64_t kMs = 1000000;

Rigid3 At(double x) {
  return {Eigen::Quaterniond::Identity(), {x, 0, 0}};
}

class ViewQueueTest : public ::testing::Test {
 protected:
  static SourceOptions Every(double metres) {
    SourceOptions options;
    options.every_m = metres;
    return options;
  }
  void AddImage(std::int64_t ms) {
    queue_.AddImage(ms * kMs, "cam0", [] { return cv::Mat(); });
  }
  std::vector<std::int64_t> Drain() {
    queue_.Close();
    std::vector<std::int64_t> result;
    while (const auto source = queue_.Pop()) {
      result.push_back(source->stamp_ns / kMs);
    }
    return result;
  }

  ViewQueue queue_{{5, 3, 100 * kMs}, Every(0.02), At(1)};
};

TEST_F(ViewQueueTest, InterpolatesPosesWhateverComesFirst) {
  AddImage(50);
  queue_.AddPose(0, At(0));
  queue_.AddPose(100 * kMs, At(1));
  AddImage(75);
  queue_.Close();
  const auto first = queue_.Pop();
  ASSERT_TRUE(first);
  EXPECT_EQ(first->stamp_ns, 50 * kMs);
  EXPECT_NEAR(first->T_N_C.t.x(), 1.5, 1e-12);  // and the camera on the body
  EXPECT_NEAR(queue_.Pop()->T_N_C.t.x(), 1.75, 1e-12);
  EXPECT_FALSE(queue_.Pop());
}

TEST_F(ViewQueueTest, SkipsWhatHasNotMovedOrHasNoPose) {
  queue_.AddPose(100 * kMs, At(0));
  AddImage(50);  // before all poses
  AddImage(100);
  AddImage(110);  // 1 cm on
  AddImage(130);
  queue_.AddPose(200 * kMs, At(0.1));
  queue_.AddPose(150 * kMs, At(7));  // back in time
  queue_.AddPose(500 * kMs, At(2));
  AddImage(300);  // within a gap
  EXPECT_THAT(Drain(), ::testing::ElementsAre(100, 130));
  EXPECT_EQ(queue_.counts().without_pose, 2);
  EXPECT_EQ(queue_.counts().images, 5);
  EXPECT_EQ(queue_.counts().poses, 3);
}

TEST_F(ViewQueueTest, DropsTheOldestWhenFull) {
  for (int i = 0; i < 7; ++i) {
    AddImage(i * 10);  // the first two go without having waited for poses
  }
  for (int i = 0; i < 7; ++i) {
    queue_.AddPose(i * 10 * kMs, At(i));
  }
  EXPECT_THAT(Drain(), ::testing::ElementsAre(40, 50, 60));
  EXPECT_EQ(queue_.counts().without_pose, 2);
  EXPECT_EQ(queue_.counts().sources, 5);
  EXPECT_EQ(queue_.counts().dropped, 2);
}

TEST_F(ViewQueueTest, AWorkerWaitsUntilItIsClosed) {
  int count = 0;
  std::thread worker([&] {
    while (queue_.Pop()) {
      ++count;
    }
  });
  queue_.AddPose(0, At(0));
  AddImage(0);
  queue_.Close();
  worker.join();
  EXPECT_EQ(count, 1);
}

}  // namespace
}  // namespace deja_view
