#include "ch5_backend/world/csv.h"

#include <algorithm>
#include <cassert>
#include <cerrno>
#include <charconv>
#include <cstdio>
#include <cstring>
#include <memory>

namespace ch5 {
namespace {

[[noreturn]] void Fail(const std::filesystem::path& path, int error) {
  throw WriteError("cannot write " + path.string() + ": " + std::strerror(error));
}

struct Closer {
  void operator()(std::FILE* file) const { std::fclose(file); }
};

// 0, or the errno of what failed. A full disk may show only when the last buffer is flushed.
int WriteAll(const std::filesystem::path& path, std::string_view text) {
  std::unique_ptr<std::FILE, Closer> file(std::fopen(path.c_str(), "wb"));
  if (!file) return errno;
  if (std::fwrite(text.data(), 1, text.size(), file.get()) != text.size()) return errno;
  if (std::fflush(file.get()) != 0) return errno;
  return std::fclose(file.release()) == 0 ? 0 : errno;
}

}  // namespace

void WriteFileAtomically(const std::filesystem::path& path, std::string_view text) {
  std::error_code error;
  if (path.has_parent_path()) std::filesystem::create_directories(path.parent_path(), error);
  if (error) Fail(path.parent_path(), error.value());
  const std::filesystem::path partial = path.string() + ".partial";
  if (const int code = WriteAll(partial, text)) {
    std::filesystem::remove(partial, error);
    Fail(path, code);
  }
  std::filesystem::rename(partial, path, error);
  if (error) {
    const int code = error.value();
    std::filesystem::remove(partial, error);
    Fail(path, code);
  }
}

CsvTable::CsvTable(std::string_view header)
    : columns_(1 + static_cast<size_t>(std::count(header.begin(), header.end(), ','))), text_(header) {
  text_ += '\n';
}

void CsvTable::CheckWidth(size_t cells) const {
  if (cells == columns_) return;
  throw std::invalid_argument("CsvTable: a row of " + std::to_string(cells) + " cells under a header of " +
                              std::to_string(columns_));
}

void CsvTable::AppendWord(std::string_view word) {
  assert(word.find_first_of(",\n\"") == std::string_view::npos && "a word in a table has no comma, quote or newline");
  text_ += word;
  text_ += ',';
}

void CsvTable::AppendNumber(double number) {
  char buffer[32];
  AppendWord({buffer, static_cast<size_t>(std::to_chars(buffer, buffer + sizeof buffer, number).ptr - buffer)});
}

void CsvTable::AppendNumber(long long number) { AppendWord(std::to_string(number)); }

}  // namespace ch5
