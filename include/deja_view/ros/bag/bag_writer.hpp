#pragma once

#include "deja_view/base/check.hpp"
#include "deja_view/base/temporary_file.hpp"
#include "deja_view/ros/messages/conversions.hpp"

#include <cstdint>
#include <exception>
#include <filesystem>
#include <string>

#include <rosbag/bag.h>
#include <rosbag/message_instance.h>

namespace deja_view {

/// Writes a bag under a temporary name in the same directory; Close gives it its own name, so that
/// nobody ever reads half a bag. Without Close nothing is left behind.
class BagWriter {
 public:
  /// Creates missing parent directories. Throws InputError that names the path when it can't be
  /// written.
  explicit BagWriter(const std::filesystem::path& path);
  ~BagWriter();
  BagWriter(const BagWriter&) = delete;
  BagWriter& operator=(const BagWriter&) = delete;

  /// Appends a message recorded at `time_ns`, 1 ns or later. Throws InputError when the disk is
  /// full.
  template <typename Message>
  void Write(const std::string& topic, std::int64_t time_ns, const Message& message) {
    try {
      bag_.write(topic, ToRosTime(time_ns), message);
    } catch (const rosbag::BagException& e) {
      ThrowUnwritable(e.what());
    }
  }

  /// Appends a message of another bag as it is: bytes, type, time and what is known of its
  /// publisher.
  void Copy(const rosbag::MessageInstance& instance);

  /// Writes the index and renames the bag into place.
  void Close();

 private:
  [[noreturn]] void ThrowUnwritable(const std::string& what) const;

  std::filesystem::path path_;
  TemporaryFile temporary_;
  rosbag::Bag bag_;
  bool is_open_ = false;
};

}  // namespace deja_view
