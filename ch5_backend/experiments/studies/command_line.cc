#include "ch5_backend/experiments/studies/command_line.h"

#include <algorithm>
#include <charconv>
#include <cstdio>
#include <filesystem>
#include <new>
#include <sstream>
#include <stdexcept>

#include "ch5_backend/files/tables/text_writer.h"
#include "ch5_backend/files/text_reader.h"
#include "ch5_backend/math/simd.h"

namespace ch5 {
namespace {

bool IsOption(const std::string& word) { return word.size() > 1 && word[0] == '-'; }

}  // namespace

template <typename T>
T NumberIn(const std::string& word, T low, T high) {
  T number{};
  const char* end = word.data() + word.size();
  const auto [stop, error] = std::from_chars(word.data(), end, number);
  if (error == std::errc() && stop == end && number >= low && number <= high) return number;
  std::ostringstream message;
  message << "must be a " << (std::is_integral_v<T> ? "whole " : "") << "number from " << low << " to " << high
          << ", got '" << word << "'";
  throw std::invalid_argument(message.str());
}
template int NumberIn(const std::string&, int, int);
template double NumberIn(const std::string&, double, double);

CommandLine::CommandLine(std::string program, std::string usage)
    : program_(std::move(program)), usage_(std::move(usage)) {}

void CommandLine::Argument(const std::string& name, std::string* value) {
  argument_name_ = name;
  argument_ = value;
}

void CommandLine::Option(const std::string& option, std::function<void(const std::string&)> take) {
  options_.emplace_back(option, std::move(take));
}

void CommandLine::Flag(const std::string& option, std::function<void()> set) {
  flags_.emplace_back(option, std::move(set));
}

void CommandLine::Text(const std::string& option, std::string* value) {
  texts_.emplace_back(option, value);
  Option(option, [value](const std::string& word) {
    if (word.empty() || word.rfind("--", 0) == 0) throw std::invalid_argument("needs a value, got '" + word + "'");
    *value = word;
  });
}

template <typename T>
void CommandLine::Number(const std::string& option, T low, T high, T* value) {
  Option(option, [=](const std::string& word) { *value = NumberIn(word, low, high); });
}
template void CommandLine::Number(const std::string&, int, int, int*);
template void CommandLine::Number(const std::string&, double, double, double*);

void CommandLine::Parse(int argc, char** argv) {
  for (int i = 1; i < argc; ++i) {
    const std::string word = argv[i];
    const auto is_this = [&](const auto& one) { return one.first == word; };
    const auto option = std::find_if(options_.begin(), options_.end(), is_this);
    const auto flag = std::find_if(flags_.begin(), flags_.end(), is_this);
    if (flag != flags_.end()) {
      flag->second();
    } else if (option != options_.end()) {
      if (i + 1 == argc) throw std::invalid_argument(word + " needs a value");
      try {
        option->second(argv[++i]);
      } catch (const std::invalid_argument& error) {
        throw std::invalid_argument(word + " " + error.what());
      }
    } else if (IsOption(word)) {
      throw std::invalid_argument("unknown option '" + word + "'");
    } else if (argument_ == nullptr) {
      throw std::invalid_argument("unknown argument '" + word + "'");
    } else if (!argument_->empty()) {
      throw std::invalid_argument("one " + argument_name_ + " at a time, got '" + *argument_ + "' and '" + word + "'");
    } else {
      *argument_ = word;
    }
  }
  if (argument_ != nullptr && argument_->empty()) throw std::invalid_argument("which " + argument_name_ + "?");
  for (const auto& [option, value] : texts_) {
    if (value->empty()) throw std::invalid_argument(option + " is missing");
  }
}

int CommandLine::Run(int argc, char** argv, const std::function<void()>& run) {
  const auto asks_for_help = [](const std::string& word) { return word == "--help" || word == "-h"; };
  if (std::any_of(argv + 1, argv + argc, asks_for_help)) return std::fputs(usage_.c_str(), stdout) < 0 ? 2 : 0;
  // An error in the data is an error in the file that was read.
  const auto of_file = [&](const std::string& what) { return argument_ ? *argument_ + ": " + what : what; };
  try {
    Parse(argc, argv);
  } catch (const std::invalid_argument& error) {
    return Fail(std::string(error.what()) + "; see --help");
  }
  try {
    GetSimdLevel();  // throws if CH5_SIMD is wrong, before any work is done
  } catch (const std::invalid_argument& error) {
    return Fail(error.what());
  }
  try {
    run();
    if (std::fflush(stdout) != 0 || std::ferror(stdout)) return Fail("cannot write to standard output");
  } catch (const std::filesystem::filesystem_error& error) {
    return Fail("cannot write " + error.path1().string() + ": " + error.code().message());
  } catch (const FileError& error) {  // names its file
    return Fail(error.what());
  } catch (const WriteError& error) {  // likewise
    return Fail(error.what());
  } catch (const std::bad_alloc&) {
    return Fail(of_file("not enough memory"));
  } catch (const std::exception& error) {
    return Fail(of_file(error.what()));
  }
  return 0;
}

int CommandLine::Fail(const std::string& what) const {
  std::fflush(stdout);
  std::fprintf(stderr, "%s: %s\n", program_.c_str(), what.c_str());
  return 2;
}

}  // namespace ch5
