#include "ch5_backend/math/eigen_types.h"

void ch5::SameStandardLibrary(const std::vector<std::string>&) {}
