#pragma once

#include <atomic>
#include <exception>

#include <ros/init.h>
#include <ros/node_handle.h>

namespace deja_view {

/// Prepares ROS for a node that finishes what it is at before it ends. Returns what SIGINT and
/// SIGTERM set.
const std::atomic<bool>& InitNode(int argc, char** argv, const char* name);

/// One line in the node's log, and so on standard error.
void ReportFatal(const char* name, const char* what);

/// `main` of a node: makes a Node and calls its Run(stop). What it throws ends it, and is told.
template <typename Node>
int RunNode(int argc, char** argv, const char* name) {
  const std::atomic<bool>& stop = InitNode(argc, argv, name);
  int code = 1;
  {
    // With the last handle rosconsole ends, too: one must outlive a node that can't be made.
    const ros::NodeHandle handle;
    try {
      Node node;
      code = node.Run(stop);
    } catch (const std::exception& e) {
      ReportFatal(name, e.what());
    }
  }
  ros::shutdown();
  return code;
}

}  // namespace deja_view
