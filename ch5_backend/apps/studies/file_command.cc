#include "ch5_backend/apps/studies/file_command.h"

#include <algorithm>
#include <charconv>
#include <cstdio>
#include <cstring>
#include <filesystem>
#include <new>
#include <stdexcept>
#include <thread>

#include "ch5_backend/world/text_reader.h"
#include "ch5_backend/world/text_writer.h"

namespace ch5 {
namespace {

// What the command line cannot mean.
class UsageError : public std::runtime_error {
 public:
  using std::runtime_error::runtime_error;
};

template <typename T>
T ParseNumber(const std::string& option, const std::string& word, T low, T high) {
  T value{};
  const auto [stop, error] = std::from_chars(word.data(), word.data() + word.size(), value);
  const bool is_number = error == std::errc() && stop == word.data() + word.size();
  if (!is_number || !(value >= low && value <= high)) {
    throw UsageError(option + " must be a " + (std::is_integral_v<T> ? "whole " : "") + "number from " +
                     std::to_string(low) + " to " + std::to_string(high) + ", got '" + word + "'");
  }
  return value;
}

ReducedSolverType ParseSolver(const std::string& word) {
  std::string known;
  for (const auto& [name, type] : kReducedSolverNames) {
    if (word == name) return type;
    known += (known.empty() ? "" : ", ") + name;
  }
  throw UsageError("--solver must be one of " + known + ", got '" + word + "'");
}

FileCommand Parse(int argc, char** argv) {
  FileCommand command;
  command.options.threads = static_cast<int>(std::max(1u, std::min(64u, std::thread::hardware_concurrency())));
  for (int i = 1; i < argc; ++i) {
    const std::string word = argv[i];
    const auto value = [&]() -> std::string {
      if (i + 1 == argc) throw UsageError(word + " needs a value");
      return argv[++i];
    };
    if (word == "--out") {
      command.out = value();
    } else if (word == "--iterations") {
      command.options.iterations = ParseNumber(word, value(), 0, 1000000);
    } else if (word == "--threads") {
      command.options.threads = ParseNumber(word, value(), 1, 256);
    } else if (word == "--huber") {
      command.options.huber = ParseNumber(word, value(), 1e-6, 1e6);
    } else if (word == "--solver") {
      command.options.solver = ParseSolver(value());
    } else if (word.size() > 1 && word[0] == '-') {
      throw UsageError("unknown option '" + word + "'");
    } else if (!command.file.empty()) {
      throw UsageError("one FILE at a time, got '" + command.file + "' and '" + word + "'");
    } else {
      command.file = word;
    }
  }
  if (command.file.empty()) throw UsageError("which FILE?");
  if (command.out.empty()) throw UsageError("--out DIR is missing");
  return command;
}

}  // namespace

std::string FileCommand::Name() const { return std::filesystem::path(file).stem().string(); }

int RunFileCommand(const char* program, const char* usage, int argc, char** argv,
                   const std::function<void(const FileCommand&)>& run) {
  for (int i = 1; i < argc; ++i) {
    if (!std::strcmp(argv[i], "--help") || !std::strcmp(argv[i], "-h")) return std::fputs(usage, stdout) < 0 ? 2 : 0;
  }
  const auto fail = [&](const std::string& what) {
    std::fflush(stdout);
    std::fprintf(stderr, "%s: %s\n", program, what.c_str());
    return 2;
  };
  FileCommand command;
  try {
    command = Parse(argc, argv);
    run(command);
    if (std::fflush(stdout) != 0 || std::ferror(stdout)) return fail("cannot write to standard output");
  } catch (const UsageError& error) {
    return fail(std::string(error.what()) + "; see --help");
  } catch (const FileError& error) {  // names its file
    return fail(error.what());
  } catch (const WriteError& error) {
    return fail(error.what());
  } catch (const std::filesystem::filesystem_error& error) {
    return fail("cannot write " + command.out + ": " + error.code().message());
  } catch (const std::invalid_argument& error) {
    return fail(command.file + ": " + error.what());
  } catch (const std::bad_alloc&) {
    return fail(command.file + ": not enough memory");
  }
  return 0;
}

IterationTable::IterationTable() {
  std::printf("iter           cost      change    gradient        step     gain    lambda  trials  seconds\n");
}

void IterationTable::Print(const IterationInfo& info) {
  const double change = info.iteration == 0 ? 0.0 : info.cost - previous_cost_;
  previous_cost_ = info.cost;
  std::printf("%4d  %13.6e  %10.2e  %10.2e  %10.2e  %7.3f  %8.1e  %6d  %7.3f\n", info.iteration, info.cost, change,
              info.gradient_max, info.step_norm, info.gain_ratio, info.lambda, info.trials, info.seconds);
  std::fflush(stdout);
}

void PrintSummary(const Summary& summary, const std::string& more) {
  std::printf("\ncost %.6e -> %.6e%s, %d iterations, %.3f s; %s\n", summary.initial_cost, summary.final_cost,
              more.c_str(), summary.iterations, summary.seconds, summary.message.c_str());
}

}  // namespace ch5
