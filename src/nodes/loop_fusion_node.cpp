#include "deja_view/ros/nodes/loop_fusion_node.hpp"

#include <atomic>
#include <csignal>
#include <exception>

#include <ros/console.h>
#include <ros/init.h>

namespace {

std::atomic<bool> stop{false};
static_assert(std::atomic<bool>::is_always_lock_free, "a signal handler may only set such a flag");

void OnSignal(int /*signal*/) {
  stop = true;
}

}  // namespace

int main(int argc, char** argv) {
  // Our own handler: keyframes that wait are finished, and published, before ROS shuts down.
  ros::init(argc, argv, "loop_fusion", ros::init_options::NoSigintHandler);
  std::signal(SIGINT, OnSignal);
  std::signal(SIGTERM, OnSignal);
  int code = 1;
  try {
    deja_view::LoopFusionNode node;
    code = node.Run(stop);
  } catch (const std::exception& e) {
    ROS_FATAL("loop_fusion: %s", e.what());
  }
  ros::shutdown();
  return code;
}
