# What every target of the project is compiled with, and the helper that makes a folder's library.

find_program(CCACHE_PROGRAM ccache)
if(CCACHE_PROGRAM)
  set(CMAKE_CXX_COMPILER_LAUNCHER ${CCACHE_PROGRAM})
  set(CMAKE_C_COMPILER_LAUNCHER ${CCACHE_PROGRAM})
endif()

add_library(virtdrive_options INTERFACE)
target_include_directories(virtdrive_options INTERFACE ${PROJECT_SOURCE_DIR})
target_compile_options(virtdrive_options INTERFACE
  -Wall -Wextra -Wpedantic -Werror -Wshadow -Wconversion -Wno-sign-conversion
  -Wnon-virtual-dtor -Woverloaded-virtual -Wimplicit-fallthrough
  # Designated initialisers name what differs from the defaults; the rest is meant to be left out.
  -Wno-missing-field-initializers
  # A recording is bit-identical whichever compiler contracted what: no fused multiply-add.
  -ffp-contract=off)
if(CMAKE_CXX_COMPILER_ID STREQUAL "Clang")
  # libstdc++ 12's own std::stable_sort calls what it declares deprecated.
  target_compile_options(virtdrive_options INTERFACE -Wno-deprecated-declarations)
endif()
if(CMAKE_CXX_COMPILER_ID STREQUAL "GNU")
  # g++ 12 reports false positives of these two inside libstdc++ once sanitizers are on.
  target_compile_options(virtdrive_options INTERFACE -Wno-maybe-uninitialized -Wno-restrict)
endif()

# virtdrive_library(FOLDER SOURCES... ) -> target virtdrive_FOLDER
function(virtdrive_library folder)
  add_library(virtdrive_${folder} STATIC ${ARGN})
  target_link_libraries(virtdrive_${folder} PUBLIC virtdrive_options)
endfunction()
