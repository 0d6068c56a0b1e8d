# What the project decides when it is built by itself. As another's subproject it leaves all of this to the parent.
option(CH5_LIBRARY_ONLY "Without programs, tests and homework" OFF)
option(BUILD_TESTING "Build the tests and the homework's checks where GoogleTest is found" ON)
option(CH5_FUZZ "Build the fuzz targets of the readers, with Clang" OFF)
option(CH5_BENCHMARKS "Build the peer of ./course bench where Ceres is found" ON)
option(CH5_UNITY "Compile tests and experiments several files at a time; without it compile_commands.json names each" ON)
set(CH5_OPTIMIZATION -O2 CACHE STRING "How far a release is optimized; less is quicker to build")
set(CH5_SANITIZE "" CACHE STRING "Sanitizers, such as address,undefined or thread")
set(CH5_DATA_DIR "${PROJECT_SOURCE_DIR}/../shared/data" CACHE PATH "Real recordings; tests that need them are skipped without")

if(NOT CMAKE_BUILD_TYPE AND NOT CMAKE_CONFIGURATION_TYPES)
  set(CMAKE_BUILD_TYPE Release CACHE STRING "Build type" FORCE)
endif()
set(CMAKE_CXX_FLAGS_RELEASE "${CH5_OPTIMIZATION} -DNDEBUG")
set(CMAKE_EXPORT_COMPILE_COMMANDS ON)

find_program(CH5_CCACHE ccache)
if(CH5_CCACHE)
  # The first two permissions are what ccache needs beside precompiled headers; the locale changes the compiler's messages
  # alone. With paths relative to the project, and the folder left out of the hash, a second clone finds what the first
  # one compiled. By the included files' content (depend mode) and never by preprocessed text: a header whose comment has
  # changed is another one to #pragma once, and a precompiled header that was made of the old one would not keep it from
  # being included again.
  set(CMAKE_CXX_COMPILER_LAUNCHER ${CMAKE_COMMAND} -E env CCACHE_DEPEND=1 CCACHE_SLOPPINESS=pch_defines,time_macros,locale
      CCACHE_BASEDIR=${PROJECT_SOURCE_DIR} CCACHE_NOHASHDIR=1 ${CH5_CCACHE})
endif()
