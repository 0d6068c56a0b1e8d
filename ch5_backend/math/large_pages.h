#pragma once
/// Large pages for long arrays: fewer page faults when the memory is first written, fewer TLB misses afterwards. A page fault
/// costs a microsecond or, on a virtual machine, ten; a solve writes some megabytes for the first time.

#include <cstddef>

namespace ch5 {

/// Memory that begins at a multiple of 64 bytes; in large pages, if it fills one and the system has them: to clear a page that
/// stays half empty costs more than it saves.
/// @throws std::bad_alloc
void* AllocateArray(size_t bytes);
void FreeArray(void* memory);

}  // namespace ch5
