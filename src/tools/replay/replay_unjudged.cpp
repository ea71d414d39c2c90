#include "deja_view/base/check.hpp"

#include "replay/replay_judge.hpp"

namespace deja_view {

ReplayJudge::ReplayJudge(const ReplayRequest& request) : request_(request) {
  if (!request.groundtruth.empty()) {
    ThrowInputError(
        "--groundtruth {}: this deja_view was built without the laboratory that judges replays "
        "(DEJA_VIEW_LAB=OFF)",
        request.groundtruth.string());
  }
}

ReplayVerdict ReplayJudge::Judge(const ReplayResult& /*result*/) const {
  return {};
}

}  // namespace deja_view
