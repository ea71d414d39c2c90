#pragma once

#include <csignal>
#include <stdexcept>

namespace deja_view {

/// Thrown by Interrupt::Check.
class Interrupted : public std::runtime_error {
 public:
  Interrupted() : std::runtime_error("interrupted; nothing half-written is left") {}
};

/// Turns Ctrl-C and a polite kill into an exception at the next Check, so that destructors take
/// temporary files away. Make it before any thread is started: threads inherit what it blocks.
class Interrupt {
 public:
  Interrupt() {
    sigemptyset(&signals_);
    sigaddset(&signals_, SIGINT);
    sigaddset(&signals_, SIGTERM);
    pthread_sigmask(SIG_BLOCK, &signals_, &before_);
  }
  ~Interrupt() { pthread_sigmask(SIG_SETMASK, &before_, nullptr); }
  Interrupt(const Interrupt&) = delete;
  Interrupt& operator=(const Interrupt&) = delete;

  /// Whether a signal has come since it was last asked.
  bool HasCome() const {
    const timespec no_wait{0, 0};
    return sigtimedwait(&signals_, nullptr, &no_wait) > 0;
  }
  /// Throws Interrupted when a signal has come.
  void Check() const {
    if (HasCome()) {
      throw Interrupted();
    }
  }

 private:
  sigset_t signals_{};
  sigset_t before_{};
};

}  // namespace deja_view
