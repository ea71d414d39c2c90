#include "deja_view/base/progress.hpp"

#include <sstream>

#include <gtest/gtest.h>

namespace deja_view {
namespace {

TEST(Progress, ShowsRateAndTimeLeft) {
  std::ostringstream stream;
  const Progress progress("replay", "keyframes", 900, stream, false);
  EXPECT_EQ(progress.Format(300, 10.0, "12 loops"),
            "replay: 300/900 keyframes  30 keyframes/s  left 0:20  12 loops");
  EXPECT_EQ(progress.Format(900, 3700.0, ""),
            "replay: 900/900 keyframes  0.2432 keyframes/s  took 1:01:40");
}

TEST(Progress, IsSilentUntilTheEndInALogOfAShortRun) {
  std::ostringstream stream;
  Progress progress("train", "steps", 10, stream, false);
  progress.Update(1);
  progress.Update(5);
  EXPECT_EQ(stream.str(), "");
  progress.Finish(10);
  EXPECT_NE(stream.str().find("train: 10/10 steps"), std::string::npos);
}

}  // namespace
}  // namespace deja_view
