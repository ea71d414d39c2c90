#include "deja_view/ros/bag/bag_writer.hpp"

#include <system_error>

namespace deja_view {

namespace fs = std::filesystem;

BagWriter::BagWriter(const fs::path& path) : path_(path), temporary_(path) {
  std::error_code error;
  if (fs::is_directory(path, error)) {
    ThrowUnwritable("it is a directory");
  }
  try {
    bag_.open(temporary_.path().string(), rosbag::bagmode::Write);
    is_open_ = true;
  } catch (const rosbag::BagException& e) {
    ThrowUnwritable(e.what());
  }
}

BagWriter::~BagWriter() {
  if (!is_open_) {
    return;
  }
  try {
    bag_.close();
  } catch (const std::exception&) {
    // The file goes anyway.
  }
}

void BagWriter::Copy(const rosbag::MessageInstance& instance) {
  try {
    bag_.write(instance.getTopic(), instance.getTime(), instance, instance.getConnectionHeader());
  } catch (const rosbag::BagException& e) {
    ThrowUnwritable(e.what());
  }
}

void BagWriter::Close() {
  DEJA_VIEW_CHECK(is_open_);
  try {
    bag_.close();
    is_open_ = false;
    temporary_.Rename();
  } catch (const std::exception& e) {
    ThrowUnwritable(e.what());
  }
}

void BagWriter::ThrowUnwritable(const std::string& what) const {
  ThrowInputError("{}: the bag can't be written: {}", path_.string(), what);
}

}  // namespace deja_view
