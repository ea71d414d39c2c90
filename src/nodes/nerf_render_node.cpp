#include "deja_view/ros/nodes/nerf_render_node.hpp"

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
  // Our own handler: the view at work is finished, and published, before ROS shuts down.
  ros::init(argc, argv, "nerf_render", ros::init_options::NoSigintHandler);
  std::signal(SIGINT, OnSignal);
  std::signal(SIGTERM, OnSignal);
  int code = 1;
  try {
    deja_view::NerfRenderNode node;
    code = node.Run(stop);
  } catch (const std::exception& e) {
    ROS_FATAL("nerf_render: %s", e.what());
  }
  ros::shutdown();
  return code;
}
