#include "ch5_backend/math/simd.h"

#include <cstdlib>
#include <stdexcept>
#include <string>

namespace ch5 {
namespace {

SimdLevel OfProcessor() {
#if defined(__x86_64__)
  const bool has_avx2 = __builtin_cpu_supports("avx2") && __builtin_cpu_supports("fma");
  const bool has_avx512 = has_avx2 && __builtin_cpu_supports("avx512f") && __builtin_cpu_supports("avx512dq") &&
                          __builtin_cpu_supports("avx512vl");
  return has_avx512 ? SimdLevel::kAvx512 : has_avx2 ? SimdLevel::kAvx2 : SimdLevel::kPortable;
#else
  return SimdLevel::kPortable;
#endif
}

SimdLevel Choose() {
  const SimdLevel most = OfProcessor();
  const char* text = std::getenv("CH5_SIMD");
  if (!text) return most;
  const std::string name = text;
  const auto take = [&](SimdLevel level) {
    if (level > most) throw std::invalid_argument("CH5_SIMD: this processor has no " + name);
    return level;
  };
  if (name == "portable") return SimdLevel::kPortable;
  if (name == "avx2") return take(SimdLevel::kAvx2);
  if (name == "avx512") return take(SimdLevel::kAvx512);
  throw std::invalid_argument("CH5_SIMD: '" + name + "' is none of portable, avx2 and avx512");
}

}  // namespace

SimdLevel GetSimdLevel() {
  static const SimdLevel level = Choose();
  return level;
}

}  // namespace ch5
