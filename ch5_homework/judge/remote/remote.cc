#include "ch5_homework/judge/remote/remote.h"

#include <memory>

namespace ch5::homework {
namespace {

constexpr size_t kMaxWords = 2000;  // of an exception

struct Session {
  std::vector<std::string> command;
  double seconds = 0.0;
  std::unique_ptr<WorkerProcess> worker;
  int answers = 0;
};

Session& TheSession() {
  static Session session;
  return session;
}

}  // namespace

void SetWorker(const std::vector<std::string>& command, double seconds) {
  TheSession().command = command;
  TheSession().seconds = seconds;
}

std::string EndWorker() {
  Session& session = TheSession();
  std::string printed = session.worker ? session.worker->Printed() : "";
  session.worker = nullptr;
  session.answers = 0;
  return printed;
}

int Answers() { return TheSession().answers; }

Reader Call(const std::string& function, const Writer& arguments) {
  Session& session = TheSession();
  if (!session.worker) session.worker = std::make_unique<WorkerProcess>(session.command, session.seconds);
  try {
    Reader reply(session.worker->Ask(Pack(function).Bytes() + arguments.Bytes(), function));
    bool returned;
    reply >> returned;
    ++session.answers;
    if (returned) return reply;
    throw RemoteException(reply.String().substr(0, kMaxWords));
  } catch (const WireError& error) {
    ThrowGarbage(function, error.what());
  }
}

void ThrowGarbage(const std::string& function, const std::string& what) {
  throw WorkerFailure("GARBAGE in the reply to " + function + ": " + what);
}

int NewHandle() {
  static int handle = 0;
  return ++handle;
}

}  // namespace ch5::homework
