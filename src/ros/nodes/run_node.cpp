#include "deja_view/ros/nodes/run_node.hpp"

#include <csignal>

#include <ros/console.h>
#include <ros/init.h>

namespace deja_view {
namespace {

std::atomic<bool> is_told_to_stop{false};
static_assert(std::atomic<bool>::is_always_lock_free, "a signal handler may only set such a flag");

void OnSignal(int /*signal*/) {
  is_told_to_stop = true;
}

}  // namespace

const std::atomic<bool>& InitNode(int argc, char** argv, const char* name) {
  ros::init(argc, argv, name, ros::init_options::NoSigintHandler);
  std::signal(SIGINT, OnSignal);
  std::signal(SIGTERM, OnSignal);
  return is_told_to_stop;
}

void ReportFatal(const char* name, const char* what) {
  ROS_FATAL("%s: %s", name, what);
}

}  // namespace deja_view
