"""The corpus of hostile submissions: wrong homework of stage 3, which does something else as well.

attacks/*.attacks hold them, each behind a line "// ATTACK name". START is what an attack does before main, ACT in the graded
function; any other code stands in front of that.
"""

import re
from pathlib import Path

FOLDER = Path(__file__).with_name("attacks")
ATTACK = re.compile(r"^// ATTACK (\w+)\n", re.MULTILINE)

HEAD = """#include <fcntl.h>
#include <sched.h>
#include <signal.h>
#include <sys/ipc.h>
#include <sys/mman.h>
#include <sys/mount.h>
#include <sys/prctl.h>
#include <sys/ptrace.h>
#include <sys/resource.h>
#include <sys/shm.h>
#include <sys/socket.h>
#include <sys/uio.h>
#include <unistd.h>
#include <cassert>
#include <cmath>
#include <cstring>
#include <ctime>
#include <fstream>
#include <iterator>
#include <map>
#include <new>
#include <stdexcept>
#include <string>
#include <thread>
#include <typeinfo>
#include "ch5_backend/homework_missing.h"
#include "ch5_backend/types/edge_se3_prior.h"
#include "ch5_backend/simulate/mono_ba.h"
namespace ch5::homework {  // of the worker
struct Submission;
class Values;
class Answer;
using Check = void (*)(const Submission&, const Values&, Answer*);
std::map<std::string, Check>& Checks();
}  // namespace ch5::homework
inline void Say(int to, const std::string& text) { if (write(to, text.data(), text.size()) < 0) return; }
inline void SayEverywhere(const std::string& text) { for (int k = 0; k < 64; ++k) if (fcntl(k, F_GETFL) >= 0) Say(k, text); }
inline std::string Numbers(std::initializer_list<int64_t> numbers) {
  return {reinterpret_cast<const char*>(numbers.begin()), numbers.size() * sizeof(int64_t)};
}
inline std::string Frame(const std::string& payload, size_t length) {
  return "ch5!" + std::string(reinterpret_cast<const char*>(&length), 4) + payload;
}
inline std::string Reply(std::initializer_list<int64_t> numbers) { return Frame(Numbers(numbers), 8 * numbers.size()); }
// An answer to a check: values by name, matrices of one number each.
inline std::string Text(const std::string& text) { return Numbers({static_cast<int64_t>(text.size())}) + text; }
inline std::string Matrix(const std::string& name, int64_t rows, int64_t columns, double x) {
  std::string all = Text(name) + Numbers({1, rows, columns});
  for (int64_t k = 0; k < rows * columns && k < 10000; ++k) all.append(reinterpret_cast<const char*>(&x), sizeof x);
  return all;
}
inline std::string Answered(int64_t count, const std::string& values, int64_t returned = 1) {
  const std::string all = Numbers({returned}) + Text("") + Numbers({count}) + values;
  return Frame(all, all.size());
}
inline std::string AnsweredWith(double x) {
  return Answered(6, Matrix("poses", 7, 4, x) + Matrix("fixed", 4, 1, x) + Matrix("priors", 9, 1, x) +
                         Matrix("W 0", 6, 6, x) + Matrix("measurements", 4, 18, x) + Matrix("more", 1, 1, x));
}
inline void Outlive() {
  for (int k = 1; k < 32; ++k) signal(k, SIG_IGN);
  setsid();
  prctl(PR_SET_NAME, "@MARK@");
  sleep(600);
  _exit(0);
}
inline void Fill(const std::string& folder) {
  static const std::string mebibyte(1 << 20, 'x');
  for (int file = 0; file < 40; ++file) {
    const int to = open((folder + "/@MARK@" + std::to_string(file)).c_str(), O_WRONLY | O_CREAT, 0600);
    for (int k = 0; k < 60 && to >= 0 && write(to, mebibyte.data(), mebibyte.size()) > 0; ++k) {}
    if (file * 60 > 200 && to >= 0 && lseek(to, 0, SEEK_END) >= 60 << 20) Say(2, "@MARK@");
    if (to >= 0) close(to);
  }
}
"""
TAIL = """
#ifdef START
__attribute__((constructor)) void Start() { START; }
#endif
#ifndef ACT
#define ACT
#endif
namespace ch5 {
void AddMonoBaEdges(const MonoBaScene& scene, double, double weight, MonoBa* problem) {
  ACT;
  problem->poses[0]->SetFixed();
  problem->graph.AddEdge(std::make_shared<EdgeSE3Prior>(problem->poses[2], scene.frames[1].q, scene.frames[1].p));
}
}  // namespace ch5
"""


def read_attacks(name: str) -> dict:
    """{name: its code}"""
    pieces = ATTACK.split((FOLDER / f"{name}.attacks").read_text(encoding="utf-8"))
    return dict(zip(pieces[1::2], pieces[2::2]))
