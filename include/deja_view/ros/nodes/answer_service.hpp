#pragma once

#include "deja_view/base/error_policy.hpp"

#include <deja_view/NamedMap.h>

#include <ros/console.h>

namespace deja_view {

/// Answers with the text that `body` returns, or with its InputError; `errors` takes all else.
template <typename Body>
bool AnswerService(const char* name,
                   ErrorPolicy* errors,
                   NamedMap::Response* response,
                   const Body& body) {
  response->success = 0;
  response->message = "the node has failed: see its log";
  errors->Guard([&] {
    try {
      response->message = body();
      response->success = 1;
      ROS_INFO("%s: %s", name, response->message.c_str());
    } catch (const InputError& e) {
      response->message = e.what();
      ROS_ERROR("%s: %s", name, e.what());
    }
  });
  return true;
}

}  // namespace deja_view
