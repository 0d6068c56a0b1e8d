#include "ch5_backend/math/precompiled.h"

#ifdef CH5_COMPILED_ONCE
namespace Eigen::internal {
CH5_COMPILED_ONCE()
}  // namespace Eigen::internal
#endif
