#include "deja_view/camera/pinhole_camera.hpp"
#include "deja_view/pipeline/loop_closer.hpp"

#include <iostream>
#include <memory>

/// Adds one keyframe of a plain image. The argument is a vocabulary.
int main(int /*argc*/, char** argv) {
  deja_view::PinholeParameters parameters;
  parameters.width = 640;
  parameters.height = 480;
  parameters.fx = parameters.fy = 400;
  parameters.cx = 320;
  parameters.cy = 240;
  deja_view::LoopCloser closer({},
                               std::make_shared<deja_view::PinholeCamera>(parameters),
                               deja_view::Rigid3::Identity(),
                               deja_view::Vocabulary::Open(argv[1]));
  deja_view::KeyframeInput keyframe;
  keyframe.stamp_ns = 1;
  keyframe.image = cv::Mat::zeros(parameters.height, parameters.width, CV_8UC1);
  closer.AddKeyframe(keyframe);
  std::cout << closer.keyframe_count() << " keyframe\n";
  return closer.keyframe_count() == 1 ? 0 : 1;
}
