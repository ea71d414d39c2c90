#include "deja_view/ros/nodes/nerf_render_node.hpp"

#include "deja_view/ros/nodes/run_node.hpp"

int main(int argc, char** argv) {
  return deja_view::RunNode<deja_view::NerfRenderNode>(argc, argv, "nerf_render");
}
