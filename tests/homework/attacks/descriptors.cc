/// Attacks that write to, read from and close every descriptor there is, and forge replies.

#include <fcntl.h>
#include <unistd.h>

#include <cstdio>
#include <limits>
#include <string>

#include "tests/homework/attacks/attack.h"

namespace attacks {
namespace {

void WriteEverywhere(const std::string& text) {
  for (int descriptor = 0; descriptor < 64; ++descriptor) {
    if (fcntl(descriptor, F_GETFL) < 0) continue;
    if (write(descriptor, text.data(), text.size()) < 0) continue;
  }
}

std::string Number(int64_t value) { return {reinterpret_cast<const char*>(&value), sizeof(value)}; }

std::string Frame(const std::string& payload, size_t length) {
  const auto told = static_cast<uint32_t>(length);
  return "ch5!" + std::string(reinterpret_cast<const char*>(&told), sizeof(told)) + payload;
}
std::string Frame(const std::string& payload) { return Frame(payload, payload.size()); }

// "It has returned", and four matrices, each 3×3, of NaN.
std::string NaN() {
  const double nan = std::numeric_limits<double>::quiet_NaN();
  std::string payload = Number(1);
  for (int k = 0; k < 4 * 9; ++k) {
    if (k % 9 == 0) payload += Number(3) + Number(3);
    payload.append(reinterpret_cast<const char*>(&nan), sizeof(nan));
  }
  return Frame(payload);
}

void CloseAll() {
  for (int descriptor = 0; descriptor < 64; ++descriptor) close(descriptor);
}

void CloseAllAndWait() {
  CloseAll();
  sleep(600);
}

void Flood() {
  const std::string text(1 << 16, 'x');
  for (;;) {
    if (write(1, text.data(), text.size()) < 0) break;
  }
}

void SwallowRequests() {
  char buffer[4096];
  for (int descriptor = 3; descriptor < 64; ++descriptor) {
    fcntl(descriptor, F_SETFL, O_NONBLOCK);
    while (read(descriptor, buffer, sizeof(buffer)) > 0) {
    }
  }
}

const char* const kReport = "[==========] Running 1 test.\n[       OK ] Stage11.*\n[  PASSED  ] 100 tests.\n";
const When kStart = When::kAtStart, kFunction = When::kInFunction;
[[maybe_unused]] const bool added =
    Add("garbage_in_constructor", kStart, [] { WriteEverywhere("garbage"); }) &&
    Add("reply_in_constructor", kStart, [] { WriteEverywhere(Frame(Number(1))); }) &&
    Add("nan", kFunction, [] { filling = std::numeric_limits<double>::quiet_NaN(); }) &&
    Add("garbage", kFunction, [] { WriteEverywhere(std::string(100, '\0')); }) &&
    Add("two_replies", kFunction, [] { WriteEverywhere(NaN() + NaN()); }) &&
    Add("nan_reply", kFunction, [] { WriteEverywhere(NaN()), _exit(0); }) &&
    Add("empty_reply", kFunction, [] { WriteEverywhere(Frame("")), _exit(0); }) &&
    Add("huge_reply", kFunction, [] { WriteEverywhere(Frame("", 0xFFFFFFFFu)), _exit(0); }) &&
    Add("promised_reply", kFunction, [] { WriteEverywhere(Frame("", 1 << 26)), sleep(600); }) &&
    Add("huge_matrix", kFunction,
        [] { WriteEverywhere(Frame(Number(1) + Number(1 << 30) + Number(1 << 30))), _exit(0); }) &&
    Add("negative_matrix", kFunction, [] { WriteEverywhere(Frame(Number(1) + Number(-1) + Number(-1))), _exit(0); }) &&
    Add("prints_a_report", kFunction, [] { std::fputs(kReport, stdout); }) && Add("close", kFunction, &CloseAll) &&
    Add("close_and_wait", kFunction, &CloseAllAndWait) && Add("flood", kFunction, &Flood) &&
    Add("swallow", kFunction, &SwallowRequests);

}  // namespace
}  // namespace attacks
