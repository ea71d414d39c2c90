# What find_package(deja_view) finds, from an installation, a catkin workspace's devel space or a catkin package that
# depends on us: the modules of the product as deja_view::NAME, with what they link.
set(destination share/${PROJECT_NAME}/cmake)
install(EXPORT deja_viewTargets NAMESPACE deja_view:: DESTINATION ${destination})
if(DEJA_VIEW_ROS)
  # catkin_package() writes and installs deja_viewConfig.cmake, which includes our extras.
  export(EXPORT deja_viewTargets NAMESPACE deja_view::
         FILE ${CATKIN_DEVEL_PREFIX}/${destination}/deja_viewTargets.cmake)
else()
  include(CMakePackageConfigHelpers)
  write_basic_package_version_file(
    ${PROJECT_BINARY_DIR}/deja_viewConfigVersion.cmake COMPATIBILITY SameMinorVersion)
  install(FILES ${PROJECT_SOURCE_DIR}/cmake/deja_view-extras.cmake
          DESTINATION ${destination} RENAME deja_viewConfig.cmake)
  install(FILES ${PROJECT_BINARY_DIR}/deja_viewConfigVersion.cmake DESTINATION ${destination})
endif()

set(headers_of_others PATTERN lab EXCLUDE)
if(NOT DEJA_VIEW_ROS)
  list(APPEND headers_of_others PATTERN ros EXCLUDE)
endif()
install(DIRECTORY include/deja_view nerf_render/include/deja_view DESTINATION include ${headers_of_others})
