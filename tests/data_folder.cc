#include "tests/data_folder.h"

#include <cstdlib>

namespace ch5 {

// The only file that is compiled anew where the data lie elsewhere.
std::filesystem::path DataFolder() {
  const char* named = std::getenv("CH5_DATA_DIR");
  return named != nullptr && *named != '\0' ? named : CH5_DATA_DIR;
}

}  // namespace ch5
