# deja_view_module(NAME SOURCES file... [MODULES module...] [LINK library...] [PRIVATE_LINK library...])
#
# One static library per module, deja_view_NAME, which find_package(deja_view) gives to others as deja_view::NAME; those
# of the laboratory stay here. MODULES are our own; LINK shows in our headers. Of our headers a module may include only
# those of the modules that it names: scripts/check_arrows compares.
function(deja_view_module name)
  cmake_parse_arguments(ARG "" "" "SOURCES;MODULES;LINK;PRIVATE_LINK" ${ARGN})
  set(target deja_view_${name})
  add_library(${target} STATIC ${ARG_SOURCES})
  add_library(deja_view::${name} ALIAS ${target})
  target_include_directories(
    ${target} PUBLIC $<BUILD_INTERFACE:${PROJECT_SOURCE_DIR}/include>
                     $<INSTALL_INTERFACE:include>)
  foreach(module IN LISTS ARG_MODULES)
    target_link_libraries(${target} PUBLIC deja_view_${module})
  endforeach()
  target_link_libraries(${target} PUBLIC ${ARG_LINK} PRIVATE ${ARG_PRIVATE_LINK})
  deja_view_target_defaults(${target})
  set_target_properties(${target} PROPERTIES EXPORT_NAME ${name})
  if(NOT CMAKE_CURRENT_SOURCE_DIR MATCHES "^${PROJECT_SOURCE_DIR}/src/lab/")
    install(TARGETS ${target} EXPORT deja_viewTargets ARCHIVE DESTINATION lib)
  endif()
endfunction()

# deja_view_highway(TARGET [file...]): compiles the kernels of these files and of headers in the current folder once per
# instruction set where Highway is found; without it they are plain code, and the files are left out. Tests and
# benchmarks that choose among the sets need it, too.
function(deja_view_highway target)
  if(NOT TARGET hwy::hwy OR NOT TARGET ${target})
    return()
  endif()
  target_sources(${target} PRIVATE ${ARGN})
  # Highway compiles for these instruction sets only when asked to.
  target_compile_definitions(${target} PRIVATE DEJA_VIEW_HAVE_HIGHWAY HWY_WANT_SSSE3 HWY_WANT_SSE4 HWY_WANT_AVX3_DL)
  target_link_libraries(${target} PRIVATE hwy::hwy)
  # Highway includes the kernel again for every instruction set.
  target_include_directories(${target} PRIVATE ${CMAKE_CURRENT_SOURCE_DIR})
endfunction()

# A program TARGET from files below FOLDER, with test/support; further arguments as of deja_view_unit_test.
function(deja_view_test_program target folder)
  cmake_parse_arguments(ARG "" "" "SOURCES;MODULES;LINK" ${ARGN})
  list(TRANSFORM ARG_SOURCES PREPEND ${folder}/)
  add_executable(${target} ${ARG_SOURCES})
  target_include_directories(${target} PRIVATE ${PROJECT_SOURCE_DIR}/test/support)
  foreach(module IN LISTS ARG_MODULES)
    target_link_libraries(${target} PRIVATE deja_view_${module})
  endforeach()
  target_link_libraries(${target} PRIVATE ${ARG_LINK})
  deja_view_target_defaults(${target})
endfunction()

# deja_view_unit_test(MODULE SOURCES file... [MODULES module...] [LINK library...])
#
# One test program per module, MODULE_test, from *_test.cpp in the folder below test/unit that has the module's place
# below src (nerf_render's tests are in test/unit/nerf).
function(deja_view_unit_test module)
  if(NOT DEJA_VIEW_TESTS)
    return()
  endif()
  file(RELATIVE_PATH folder ${PROJECT_SOURCE_DIR}/src ${CMAKE_CURRENT_SOURCE_DIR})
  if(folder MATCHES "^\\.\\.")
    set(folder ${module})
  endif()
  deja_view_test_program(${module}_test ${PROJECT_SOURCE_DIR}/test/unit/${folder} ${ARGN})
  target_link_libraries(${module}_test PRIVATE GTest::gmock GTest::gtest_main)
  add_test(NAME ${module} COMMAND ${module}_test)
  set_tests_properties(${module} PROPERTIES LABELS unit)
endfunction()

# deja_view_benchmark(NAME SOURCES file... [MODULES module...] [LINK library...]): test/benchmark/NAME.cpp
function(deja_view_benchmark name)
  if(DEJA_VIEW_BENCHMARKS)
    deja_view_test_program(${name} ${PROJECT_SOURCE_DIR}/test/benchmark ${ARGN})
    target_link_libraries(${name} PRIVATE benchmark::benchmark benchmark::benchmark_main)
  endif()
endfunction()
