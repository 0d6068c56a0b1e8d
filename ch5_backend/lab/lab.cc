// ch5_lab QUERY: what the lab's page shows for these settings, as JSON on standard output. The page has the same program
// as WebAssembly.

#include <cstdio>

#include "ch5_backend/lab/panels.h"

#ifdef __EMSCRIPTEN__
#include <emscripten.h>

/// The answer stays until the next question.
extern "C" EMSCRIPTEN_KEEPALIVE const char* LabAnswer(const char* query) {
  static std::string answer;
  answer = ch5::lab::Answer(query);
  return answer.c_str();
}
#else
int main(int argc, char** argv) {
  if (argc != 2 || argv[1] == std::string("--help")) {
    std::fprintf(argc == 2 ? stdout : stderr, "usage: ch5_lab QUERY, such as 'panel=solve&weight=100'\n");
    return argc == 2 ? 0 : 2;
  }
  const std::string answer = ch5::lab::Answer(argv[1]);
  std::puts(answer.c_str());
  return answer.rfind("{\"error\"", 0) == 0 ? 2 : 0;
}
#endif
