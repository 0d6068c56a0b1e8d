#pragma once
/// Large pages for long arrays: the system then hands over their memory in fewer pieces, and finds it with fewer misses.

#include <cstddef>

namespace ch5 {

/// Asks for them where whole ones fit into this memory, which nobody has written yet; the system may refuse.
void AskForLargePages(void* memory, size_t bytes);

}  // namespace ch5
