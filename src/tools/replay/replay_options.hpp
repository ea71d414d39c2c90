#pragma once

#include "replay/replay.hpp"

namespace CLI {
class App;
}

namespace deja_view {

/// The options that say what is replayed and how: bag, camera, config, map, and shortcuts to the
/// loop closer's options. Keep a reference to `request`.
void AddReplayInput(CLI::App* sub, ReplayRequest* request);

}  // namespace deja_view
