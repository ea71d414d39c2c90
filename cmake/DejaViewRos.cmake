# Finds catkin, generates the messages and exports the package. Included by the root CMakeLists.txt only
# where ROS is wanted, before anything is added: catkin_package() must run in the package's root.

# The first python3 in PATH may be one without catkin's modules (pyenv, conda); the distribution's has them.
foreach(variable PYTHON_EXECUTABLE Python3_EXECUTABLE)
  if(NOT ${variable} AND EXISTS /usr/bin/python3)
    set(${variable} /usr/bin/python3 CACHE FILEPATH "Python with catkin's modules")
  endif()
endforeach()

# Our tests are CTest tests with or without a catkin workspace; catkin's own test targets, which build a second
# GoogleTest, are not needed.
set(DEJA_VIEW_SAVED_SHARED_LIBS ${BUILD_SHARED_LIBS})
set(DEJA_VIEW_SAVED_BIN_DIRECTORY ${CMAKE_RUNTIME_OUTPUT_DIRECTORY})
if(NOT DEFINED CATKIN_ENABLE_TESTING)
  set(CATKIN_ENABLE_TESTING OFF CACHE BOOL "catkin's own test targets")
endif()

# Bags need no roscpp, and a tool that reads them shall not load it.
find_package(catkin REQUIRED COMPONENTS cpp_common rosbag_storage roscpp_serialization rostime)
set(DEJA_VIEW_BAG_LIBRARIES ${catkin_LIBRARIES})
find_package(catkin REQUIRED COMPONENTS
  diagnostic_msgs diagnostic_updater geometry_msgs message_generation nav_msgs rosbag_storage roscpp
  sensor_msgs std_msgs tf2 tf2_msgs tf2_ros topic_tools visualization_msgs)

add_message_files(DIRECTORY msg FILES LoopConstraint.msg VirtualFrame.msg)
add_service_files(DIRECTORY srv FILES NamedMap.srv)
generate_messages(DEPENDENCIES geometry_msgs std_msgs)

catkin_package(CATKIN_DEPENDS geometry_msgs message_runtime std_msgs CFG_EXTRAS deja_view-extras.cmake)

set(BUILD_SHARED_LIBS ${DEJA_VIEW_SAVED_SHARED_LIBS})
set(CMAKE_RUNTIME_OUTPUT_DIRECTORY ${DEJA_VIEW_SAVED_BIN_DIRECTORY})

install(DIRECTORY launch DESTINATION ${CATKIN_PACKAGE_SHARE_DESTINATION})
