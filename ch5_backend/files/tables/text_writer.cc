#include "ch5_backend/files/tables/text_writer.h"

#include <unistd.h>

#include <atomic>
#include <cerrno>
#include <charconv>
#include <cstdio>
#include <cstring>
#include <memory>

namespace ch5 {
namespace {

namespace fs = std::filesystem;

void Check(const fs::path& path, int error) {
  if (error != 0) throw WriteError("cannot write " + path.string() + ": " + std::strerror(error));
}

struct FileCloser {
  void operator()(std::FILE* file) const { std::fclose(file); }
};

// 0, or the errno of what failed. A full disk may show only when the last buffer is flushed.
// Mode "x": the file must be new.
int WriteAll(const fs::path& path, const char* mode, std::string_view text) {
  std::unique_ptr<std::FILE, FileCloser> file(std::fopen(path.c_str(), mode));
  if (!file) return errno;
  if (std::fwrite(text.data(), 1, text.size(), file.get()) != text.size()) return errno;
  if (std::fflush(file.get()) != 0) return errno;
  return std::fclose(file.release()) == 0 ? 0 : errno;
}

// In the folder of `path`, so that it can be renamed to it. Two runs into one folder must not write the same file; the
// name's length does not depend on `path`, which may be as long as a name can be.
fs::path TemporaryName(const fs::path& path) {
  static std::atomic<int> count{0};
  return path.parent_path() / (".ch5-" + std::to_string(getpid()) + "-" + std::to_string(count++) + ".partial");
}

template <typename T>
void Append(T value, char end, std::string* text) {
  char digits[32];
  char* stop = std::to_chars(digits, digits + sizeof digits - 1, value).ptr;
  *stop++ = end;
  text->append(digits, stop);
}

}  // namespace

FileBatch::~FileBatch() {
  std::error_code ignored;
  for (const File& file : files_) fs::remove(file.partial, ignored);
}

void FileBatch::Add(const fs::path& path, std::string_view text) {
  std::error_code error;
  if (path.has_parent_path()) fs::create_directories(path.parent_path(), error);
  if (error) Check(path.parent_path(), error.value());
  if (!input_.empty() && fs::equivalent(path, input_, error)) {
    throw WriteError("cannot write " + path.string() + ": it is the input; choose another folder for the results");
  }
  const fs::file_status status = fs::status(path, error);
  if (fs::is_directory(status)) Check(path, EISDIR);
  if (fs::exists(status) && !fs::is_regular_file(status)) return Check(path, WriteAll(path, "wb", text));
  for (int failure = EEXIST; failure == EEXIST;) {  // another computer's process may have our number
    const fs::path partial = TemporaryName(path);
    failure = WriteAll(partial, "wbx", text);
    if (failure != EEXIST) files_.push_back({partial, path});
    if (failure != EEXIST) Check(path, failure);
  }
}

void FileBatch::Commit() {
  std::error_code error;
  for (const File& file : files_) {
    fs::rename(file.partial, file.path, error);
    Check(file.path, error.value());
  }
  files_.clear();
}

OutputFolder::OutputFolder(const fs::path& path) {
  for (fs::path folder = path; !folder.empty() && !fs::exists(folder); folder = folder.parent_path()) {
    made_.push_back(folder);
  }
  fs::create_directories(path);
}

OutputFolder::~OutputFolder() {
  std::error_code is_not_empty;
  for (const fs::path& folder : made_) fs::remove(folder, is_not_empty);
}

void WriteFileAtomically(const fs::path& path, std::string_view text) {
  FileBatch batch;
  batch.Add(path, text);
  batch.Commit();
}

void AppendNumber(double value, char end, std::string* text) { Append(value, end, text); }
void AppendNumber(int64_t value, char end, std::string* text) { Append(value, end, text); }

}  // namespace ch5
