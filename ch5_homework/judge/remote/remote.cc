#include "ch5_homework/judge/remote/remote.h"

#include <memory>

#include "ch5_homework/judge/ask.h"
#include "ch5_homework/judge/remote/wire.h"

namespace ch5::homework {
namespace {

constexpr size_t kMaxWords = 2000;  // of an exception
constexpr double kAfterTimeout =
    0.125;  // of the time limit, for the tests after one that has not ended: they may be quick

struct Session {
  std::vector<std::string> command;
  double seconds = 0.0;
  bool has_timed_out = false;
  std::string never_started;  // why, if a worker has not come to its main in time: none will
  std::unique_ptr<WorkerProcess> worker;
  int answers = 0;
};

Session& TheSession() {
  static Session session;
  return session;
}

std::string Question(const std::string& check, const Values& given) {
  Writer question;
  question.String(check);
  question.All(given);
  return question.Bytes();
}

// The worker greets before anything of the student's runs; that it replies to a question of nothing shows that its main is reached.
void StartWorker(Session* session) {
  const double limit = session->has_timed_out ? kAfterTimeout * session->seconds : session->seconds;
  session->worker = std::make_unique<WorkerProcess>(session->command, limit);
  session->worker->Ask(Question("", {}), kItsStart);
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

Answer Ask(const std::string& check, const Values& given) {
  Session& session = TheSession();
  if (!session.never_started.empty()) throw WorkerFailure(session.never_started);
  try {
    if (!session.worker) StartWorker(&session);
    Reader reply(session.worker->Ask(Question(check, given), check));
    Answer answer;
    const bool returned = reply.Bool();
    const std::string words = reply.String().substr(0, kMaxWords);
    reply.All(&answer);
    reply.End();
    if (!returned) answer.SetFailure(std::make_exception_ptr(RemoteException(words)));
    ++session.answers;
    return answer;
  } catch (const WorkerFailure& failure) {
    const std::string words = failure.what();
    if (words.find("TIMEOUT") != std::string::npos) {
      session.has_timed_out = true;
      if (words.find(kItsStart) != std::string::npos) session.never_started = words;
    }
    throw;
  }
}

}  // namespace ch5::homework
