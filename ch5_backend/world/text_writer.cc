#include "ch5_backend/world/text_writer.h"

#include <sys/stat.h>
#include <unistd.h>

#include <cerrno>
#include <charconv>
#include <cstdio>
#include <cstring>

namespace ch5 {
namespace {

[[noreturn]] void FailToWrite(const std::string& path, const std::string& why) {
  throw FileError(path + ": cannot be written: " + why);
}

// Empty on success; a full disk may show only when the file is closed.
std::string Write(const std::string& path, std::string_view text) {
  std::FILE* file = std::fopen(path.c_str(), "wb");
  if (!file) return std::strerror(errno);
  std::string why;
  if (std::fwrite(text.data(), 1, text.size(), file) != text.size()) why = std::strerror(errno);
  if (std::fclose(file) != 0 && why.empty()) why = std::strerror(errno);
  return why;
}

template <typename T>
void Append(T value, char end, std::string* text) {
  char digits[32];
  *text += std::string_view(digits, std::to_chars(digits, digits + sizeof digits, value).ptr - digits);
  *text += end;
}

}  // namespace

FileBatch::~FileBatch() {
  for (const File& file : files_) unlink(file.temporary.c_str());
}

void FileBatch::Add(const std::string& path, std::string_view text) {
  struct stat status;
  const bool exists = stat(path.c_str(), &status) == 0;
  if (exists && S_ISDIR(status.st_mode)) FailToWrite(path, "it is a directory");
  if (exists && !S_ISREG(status.st_mode)) {  // a device must not be replaced by a file
    if (const std::string why = Write(path, text); !why.empty()) FailToWrite(path, why);
    return;
  }
  files_.push_back({path + ".tmp" + std::to_string(getpid()), path});
  if (const std::string why = Write(files_.back().temporary, text); !why.empty()) FailToWrite(path, why);
}

void FileBatch::Commit() {
  for (const File& file : files_) {
    if (std::rename(file.temporary.c_str(), file.path.c_str()) != 0) FailToWrite(file.path, std::strerror(errno));
  }
  files_.clear();
}

void WriteFile(const std::string& path, std::string_view text) {
  FileBatch batch;
  batch.Add(path, text);
  batch.Commit();
}

void AppendNumber(double value, char end, std::string* text) { Append(value, end, text); }
void AppendNumber(int value, char end, std::string* text) { Append(value, end, text); }

}  // namespace ch5
