#pragma once

#include <cstddef>
#include <cstdint>
#include <string>
#include <vector>

namespace deja_view::internal {

/// What lies where in a serialised message, by the text of its definition: checks that the lengths
/// in it stay within its bytes, since roscpp makes room for them before it looks.
class MessageLayout {
 public:
  /// `type` as "sensor_msgs/Image", `definition` with those of all types in it, as
  /// ros::message_traits gives it.
  MessageLayout(const std::string& type, const std::string& definition);

  /// "" or which field says more than there is, as "channels.values".
  std::string FindOverrun(const std::uint8_t* data, std::size_t size) const;

 private:
  static constexpr std::uint32_t kAnyCount = 0xFFFFFFFF;
  struct Field {
    std::string name;
    std::string type;
    std::size_t size = 0;    ///< of a number in bytes
    std::size_t nested = 0;  ///< which of types_; of neither number nor text
    bool is_text = false;
    bool is_array = false;
    std::uint32_t count = 1;  ///< kAnyCount: the message says
  };
  struct Type {
    std::string name;
    std::vector<Field> fields;
  };
  struct Bytes {
    const std::uint8_t* at;
    std::size_t left;
    bool Skip(std::uint64_t count);
    bool Read(std::uint32_t* count);
  };

  static void AddField(const std::string& line, Type* type);
  void Resolve();
  std::string Walk(const Type& type, Bytes* bytes) const;
  std::string WalkField(const Field& field, Bytes* bytes) const;

  std::vector<Type> types_;  ///< the message's own first
};

}  // namespace deja_view::internal
