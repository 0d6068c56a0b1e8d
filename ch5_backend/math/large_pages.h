#pragma once
/// Large pages for long arrays: fewer page faults when the memory is first written, fewer TLB misses afterwards.

#include <cstddef>

namespace ch5 {

/// Asks for them where whole ones fit into this memory, which must not have been written yet; the system may refuse.
void AskForLargePages(void* memory, size_t bytes);

}  // namespace ch5
