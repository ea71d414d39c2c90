#include "deja_view/ros/nodes/loop_fusion_node.hpp"

#include "deja_view/ros/nodes/run_node.hpp"

int main(int argc, char** argv) {
  return deja_view::RunNode<deja_view::LoopFusionNode>(argc, argv, "loop_fusion");
}
