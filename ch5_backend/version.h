#pragma once
/// The library's version; CMakeLists.txt, the packages and the name of the shared library take it from here.

#define CH5_VERSION_MAJOR 1
#define CH5_VERSION_MINOR 0
#define CH5_VERSION_PATCH 0
