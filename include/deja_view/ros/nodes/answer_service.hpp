#pragma once

#include "deja_view/base/error_policy.hpp"

#include <filesystem>
#include <string>

#include <deja_view/NamedMap.h>

#include <ros/console.h>

namespace deja_view {

/// Answers with the text that `body` returns, or with what of files or their content kept it from
/// that; `errors` takes all else.
template <typename Body>
bool AnswerService(const char* name,
                   ErrorPolicy* errors,
                   NamedMap::Response* response,
                   const Body& body) {
  response->success = 0;
  response->message = "the node has failed: see its log";
  const auto refuse = [&](const std::string& why) {
    response->message = why;
    ROS_ERROR("%s: %s", name, why.c_str());
  };
  errors->Guard([&] {
    try {
      response->message = body();
      response->success = 1;
      ROS_INFO("%s: %s", name, response->message.c_str());
    } catch (const InputError& e) {
      refuse(e.what());
    } catch (const std::filesystem::filesystem_error& e) {
      refuse(e.what());
    }
  });
  return true;
}

}  // namespace deja_view
