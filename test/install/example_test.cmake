# Builds and runs the example against an installation of `build` (when `install_prefix` is given: into a folder of our
# own, by DESTDIR, since catkin installs some files by absolute paths) or against `devel_prefix`.
function(run)
  execute_process(COMMAND ${ARGN} RESULT_VARIABLE result OUTPUT_VARIABLE output ERROR_VARIABLE output)
  if(NOT result EQUAL 0)
    message(FATAL_ERROR "${ARGN}: ${result}\n${output}")
  endif()
endfunction()

file(REMOVE_RECURSE ${scratch})
if(DEFINED install_prefix)
  set(prefix ${scratch}/root${install_prefix})
  set(vocabulary ${prefix}/share/deja_view/config/vocabulary/brief.dvv)
  run(${CMAKE_COMMAND} -E env DESTDIR=${scratch}/root ${CMAKE_COMMAND} --install ${build})
else()
  set(prefix ${devel_prefix})
endif()
run(${CMAKE_COMMAND} -S ${example} -B ${scratch}/build -G ${generator} "-DCMAKE_PREFIX_PATH=${prefix}\;${ros_prefix}"
    -D CMAKE_CXX_COMPILER=${compiler} -D CMAKE_BUILD_TYPE=${build_type})
run(${CMAKE_COMMAND} --build ${scratch}/build)
run(${scratch}/build/example ${vocabulary})
