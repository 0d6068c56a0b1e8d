/// Solves a "Bundle Adjustment in the Large" file: ch5_bal FILE --out DIR.

#include <charconv>
#include <cstdio>
#include <cstring>
#include <filesystem>
#include <new>
#include <stdexcept>
#include <string>
#include <thread>

#include "ch5_backend/apps/studies/bal_study.h"
#include "ch5_backend/world/text_reader.h"
#include "ch5_backend/world/text_writer.h"

namespace {

constexpr char kUsage[] =
    "usage: ch5_bal FILE --out DIR [--iterations N] [--threads N] [--huber PIXELS]\n"
    "Solves the bundle adjustment in FILE (BAL text) and writes into DIR: the result as BAL and PLY, the table of\n"
    "iterations, a summary, and what plot/bal.py draws.\n"
    "  --iterations N   at most N iterations (50)\n"
    "  --threads N      (as many as the machine has); the result does not depend on it\n"
    "  --huber PIXELS   Huber's loss with this threshold, for data with outliers (none)\n";

// What the command line cannot mean.
class UsageError : public std::runtime_error {
 public:
  using std::runtime_error::runtime_error;
};

struct Arguments {
  std::string file, out;
  ch5::BalStudyOptions options;
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

Arguments Parse(int argc, char** argv) {
  Arguments arguments;
  arguments.options.threads = static_cast<int>(std::max(1u, std::min(64u, std::thread::hardware_concurrency())));
  for (int i = 1; i < argc; ++i) {
    const std::string word = argv[i];
    const auto value = [&]() -> std::string {
      if (i + 1 == argc) throw UsageError(word + " needs a value");
      return argv[++i];
    };
    if (word == "--out") {
      arguments.out = value();
    } else if (word == "--iterations") {
      arguments.options.iterations = ParseNumber(word, value(), 0, 1000000);
    } else if (word == "--threads") {
      arguments.options.threads = ParseNumber(word, value(), 1, 256);
    } else if (word == "--huber") {
      arguments.options.huber = ParseNumber(word, value(), 1e-6, 1e6);
    } else if (word.size() > 1 && word[0] == '-') {
      throw UsageError("unknown option '" + word + "'");
    } else if (!arguments.file.empty()) {
      throw UsageError("one FILE at a time, got '" + arguments.file + "' and '" + word + "'");
    } else {
      arguments.file = word;
    }
  }
  if (arguments.file.empty()) throw UsageError("which FILE?");
  if (arguments.out.empty()) throw UsageError("--out DIR is missing");
  return arguments;
}

void PrintIteration(const ch5::IterationInfo& info, double change) {
  std::printf("%4d  %13.6e  %10.2e  %10.2e  %10.2e  %7.3f  %8.1e  %6d  %7.3f\n", info.iteration, info.cost, change,
              info.gradient_max, info.step_norm, info.gain_ratio, info.lambda, info.trials, info.seconds);
  std::fflush(stdout);
}

void Run(const Arguments& arguments) {
  const std::string name = std::filesystem::path(arguments.file).stem().string();
  const ch5::BalProblem problem = ch5::ReadBal(arguments.file);
  std::filesystem::create_directories(arguments.out);
  std::printf("%s: %zu cameras, %zu points, %zu observations\n\n", name.c_str(), problem.cameras.size(),
              problem.points.size(), problem.observations.size());
  std::printf("iter           cost      change    gradient        step     gain    lambda  trials  seconds\n");

  double previous = 0.0;
  const ch5::BalStudy study = ch5::SolveBal(problem, arguments.options, [&](const ch5::IterationInfo& info) {
    PrintIteration(info, info.iteration == 0 ? 0.0 : info.cost - previous);
    previous = info.cost;
  });
  ch5::WriteBalStudy(study, arguments.options, name, arguments.out);
  const ch5::Summary& summary = study.summary;
  std::printf("\ncost %.6e -> %.6e, mean error %.3f -> %.3f px, %d iterations, %.3f s; %s\n", summary.initial_cost,
              summary.final_cost, study.mean_error_before, study.mean_error_after, summary.iterations, summary.seconds,
              summary.message.c_str());
}

int Fail(const std::string& what) {
  std::fflush(stdout);
  std::fprintf(stderr, "ch5_bal: %s\n", what.c_str());
  return 2;
}

}  // namespace

int main(int argc, char** argv) {
  for (int i = 1; i < argc; ++i) {
    if (!std::strcmp(argv[i], "--help") || !std::strcmp(argv[i], "-h")) return std::fputs(kUsage, stdout) < 0 ? 2 : 0;
  }
  Arguments arguments;
  try {
    arguments = Parse(argc, argv);
    Run(arguments);
    if (std::fflush(stdout) != 0 || std::ferror(stdout)) return Fail("cannot write to standard output");
  } catch (const UsageError& error) {
    return Fail(std::string(error.what()) + "; see --help");
  } catch (const ch5::FileError& error) {  // names its file
    return Fail(error.what());
  } catch (const ch5::WriteError& error) {
    return Fail(error.what());
  } catch (const std::filesystem::filesystem_error& error) {
    return Fail("cannot write " + arguments.out + ": " + error.code().message());
  } catch (const std::invalid_argument& error) {
    return Fail(arguments.file + ": " + error.what());
  } catch (const std::bad_alloc&) {
    return Fail(arguments.file + ": not enough memory");
  }
  return 0;
}
