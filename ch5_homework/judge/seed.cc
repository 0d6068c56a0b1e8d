#include "ch5_homework/judge/seed.h"

#include <cerrno>
#include <cstdlib>

#include "ch5_backend/simulate/random.h"

namespace ch5::homework {

std::optional<uint64_t>& DrawnSeed() {
  static std::optional<uint64_t> seed;
  return seed;
}

uint64_t Seed(uint64_t n) {
  if (!DrawnSeed()) return n;
  return Random(Random(*DrawnSeed()).Bits() + n).Bits();
}

int Vary(int usual, int most, uint64_t n) {
  if (!DrawnSeed()) return usual;
  return usual + static_cast<int>(Random(Seed(n)).Bits() % static_cast<uint64_t>(most - usual + 1));
}

bool TakeSeed(const std::string& option) {
  const std::string name = "--seed=";
  const std::string number = option.substr(0, name.size()) == name ? option.substr(name.size()) : "";
  if (number.empty() || number.find_first_not_of("0123456789") != std::string::npos) return false;
  errno = 0;
  DrawnSeed() = std::strtoull(number.c_str(), nullptr, 10);
  return errno == 0;
}

}  // namespace ch5::homework
