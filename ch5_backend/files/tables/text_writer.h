#pragma once
/// Files that appear together or not at all, so that a full disk or a crash never spoils an older result.

#include <cstdint>
#include <filesystem>
#include <stdexcept>
#include <string>
#include <string_view>
#include <utility>
#include <vector>

namespace ch5 {

/// A file that cannot be written; the message names it and says why.
class WriteError : public std::runtime_error {
 public:
  using std::runtime_error::runtime_error;
};

class FileBatch {
 public:
  /// @param input  a file that must not be written, since the results were made of it; "" if there is none
  explicit FileBatch(std::filesystem::path input = {}) : input_(std::move(input)) {}
  FileBatch(const FileBatch&) = delete;
  FileBatch& operator=(const FileBatch&) = delete;
  /// Without a Commit, leaves no file behind.
  ~FileBatch();

  /// Writes `text` into a file beside `path` whose name no other process uses; missing folders are made. A device or a
  /// pipe is written at once.
  /// @throws WriteError if `path` is the input, the disk is full, …; no file of the batch has then changed
  void Add(const std::filesystem::path& path, std::string_view text);

  /// Gives all the files their names.
  /// @throws WriteError if a name cannot be taken
  void Commit();

 private:
  struct File {
    std::filesystem::path partial, path;
  };
  std::filesystem::path input_;
  std::vector<File> files_;
};

/// A folder for results, made before the work so that a place that cannot be written fails at once. What is still empty at
/// the end, as when the work has failed, is removed again, but no folder that was there before.
class OutputFolder {
 public:
  /// @throws std::filesystem::filesystem_error
  explicit OutputFolder(const std::filesystem::path& path);
  OutputFolder(const OutputFolder&) = delete;
  OutputFolder& operator=(const OutputFolder&) = delete;
  ~OutputFolder();

 private:
  std::vector<std::filesystem::path> made_;  // the innermost first
};

/// A batch of one: `text` becomes `path`, whole or not at all.
void WriteFileAtomically(const std::filesystem::path& path, std::string_view text);

/// Appends the fewest digits that read back as the same number, and then `end`.
void AppendNumber(double value, char end, std::string* text);
void AppendNumber(int64_t value, char end, std::string* text);
inline void AppendNumber(int value, char end, std::string* text) { AppendNumber(int64_t{value}, end, text); }

}  // namespace ch5
