# Warnings are errors for our own targets only, so they are PRIVATE; third-party headers are SYSTEM.
option(DEJA_VIEW_WERROR "Treat warnings as errors" ON)
set(DEJA_VIEW_SANITIZER "" CACHE STRING "address,undefined | thread | (empty)")
option(DEJA_VIEW_FUZZ "Build the fuzz targets with libFuzzer (needs clang)" OFF)

# -ffp-contract=off: the same input gives the same bits whatever the compiler would fuse.
function(deja_view_target_defaults target)
  target_compile_features(${target} PUBLIC cxx_std_17)
  set_target_properties(${target} PROPERTIES CXX_EXTENSIONS OFF POSITION_INDEPENDENT_CODE ON)
  target_compile_options(
    ${target}
    PRIVATE -Wall -Wextra -Wpedantic -Wshadow -Wconversion -Wno-sign-conversion -Wnon-virtual-dtor
            -Wold-style-cast -Woverloaded-virtual -Wcast-align -ffp-contract=off
            $<$<BOOL:${DEJA_VIEW_WERROR}>:-Werror>)
  if(DEJA_VIEW_SANITIZER)
    # Eigen would align by hand under a sanitizer, and free so what Ceres' library took from malloc.
    target_compile_definitions(${target} PUBLIC EIGEN_MALLOC_ALREADY_ALIGNED=1)
    target_compile_options(${target} PUBLIC -fsanitize=${DEJA_VIEW_SANITIZER} -fno-omit-frame-pointer
                                            -fno-sanitize-recover=all)
    target_link_options(${target} PUBLIC -fsanitize=${DEJA_VIEW_SANITIZER})
  endif()
  if(DEJA_VIEW_FUZZ)
    target_compile_options(${target} PUBLIC -fsanitize=fuzzer-no-link)
  endif()
endfunction()
