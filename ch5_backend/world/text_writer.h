#pragma once
/// Files that appear together or not at all, so that a full disk or a crash never spoils an older result.

#include <string>
#include <string_view>
#include <vector>

#include "ch5_backend/world/text_reader.h"

namespace ch5 {

class FileBatch {
 public:
  FileBatch() = default;
  FileBatch(const FileBatch&) = delete;
  FileBatch& operator=(const FileBatch&) = delete;
  /// Without a Commit, leaves no trace.
  ~FileBatch();

  /// Writes `text` to a temporary file beside `path`. A device or a pipe is written at once.
  /// @throws FileError if the folder is missing, the disk is full, …; no file of the batch has then changed
  void Add(const std::string& path, std::string_view text);

  /// Puts all the files in their places.
  /// @throws FileError if a name cannot be taken, for example by a folder of that name
  void Commit();

 private:
  struct File {
    std::string temporary, path;
  };
  std::vector<File> files_;
};

/// A batch of one.
void WriteFile(const std::string& path, std::string_view text);

/// Appends the shortest digits that read back as the same double, or an integer, and then `end`.
void AppendNumber(double value, char end, std::string* text);
void AppendNumber(int value, char end, std::string* text);

}  // namespace ch5
