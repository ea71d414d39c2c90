#include "deja_view/front_end/image_queue.hpp"

#include <gtest/gtest.h>

namespace deja_view {
namespace {

ImageQueue QueueOf(std::initializer_list<std::int64_t> stamps) {
  ImageQueue queue;
  for (const std::int64_t stamp_ns : stamps) {
    queue.Add({stamp_ns, {}, 10});
  }
  return queue;
}

TEST(ImageQueue, GivesImagesByStampAndCountsTheirBytes) {
  ImageQueue queue = QueueOf({30, 10, 20});
  EXPECT_EQ(queue.bytes(), 30U);
  EXPECT_EQ(queue.back().stamp_ns, 30);
  for (const std::int64_t stamp_ns : {10, 20, 30}) {
    EXPECT_EQ(queue.Pop().stamp_ns, stamp_ns);
  }
  EXPECT_TRUE(queue.empty());
  EXPECT_EQ(queue.bytes(), 0U);
}

TEST(ImageQueue, DropsWhatLiesBeforeAndAfter) {
  ImageQueue queue = QueueOf({10, 20, 30, 40, 50});
  queue.DropBefore(20);
  queue.DropFrom(40);
  EXPECT_EQ(queue.front().stamp_ns, 20);
  EXPECT_EQ(queue.back().stamp_ns, 30);
  EXPECT_EQ(queue.bytes(), 20U);
  queue.DropBefore(100);
  queue.DropFrom(0);
  EXPECT_TRUE(queue.empty());
}

}  // namespace
}  // namespace deja_view
