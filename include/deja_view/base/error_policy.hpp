#pragma once

#include "deja_view/base/check.hpp"

#include <atomic>
#include <cstdint>
#include <exception>
#include <functional>
#include <mutex>
#include <string>
#include <utility>

namespace deja_view {

/// How a program that runs for long, on several threads, meets errors: bad input (InputError) is
/// told, counted and passed over; anything else is a broken invariant, with which the program is to
/// end. The first of these is kept for the thread that runs the program.
class ErrorPolicy {
 public:
  /// `tell` is called by the thread that met the bad input.
  explicit ErrorPolicy(std::function<void(const std::string& what)> tell)
      : tell_(std::move(tell)) {}

  /// Runs `body`; whether it came to its end.
  template <typename Body>
  bool Guard(const Body& body) {
    try {
      body();
      return true;
    } catch (const InputError& e) {
      ++bad_inputs_;
      tell_(e.what());
    } catch (...) {
      const std::lock_guard<std::mutex> lock(mutex_);
      if (!failure_) {
        failure_ = std::current_exception();
      }
      has_failed_ = true;
    }
    return false;
  }

  std::int64_t bad_inputs() const { return bad_inputs_; }
  bool has_failed() const { return has_failed_; }

  /// Throws what broke, if anything did.
  void RethrowFailure() const {
    const std::lock_guard<std::mutex> lock(mutex_);
    if (failure_) {
      std::rethrow_exception(failure_);
    }
  }

 private:
  std::function<void(const std::string& what)> tell_;
  std::atomic<std::int64_t> bad_inputs_{0};
  std::atomic<bool> has_failed_{false};
  mutable std::mutex mutex_;
  std::exception_ptr failure_;
};

}  // namespace deja_view
