// Any bytes as a BAL file: it is refused with a FileError, or what is written of it is read back as the same.
#include "ch5_backend/files/bal.h"
#include "ch5_backend/files/text_reader.h"
#include "tests/fuzz/memory_file.h"

extern "C" int LLVMFuzzerTestOneInput(const uint8_t* data, size_t size) {
  using namespace ch5;
  static const fuzz::MemoryFile file;
  file.Set(fuzz::Text(data, size));
  std::string text;
  try {
    text = FormatBal(ReadBal(file.Path()));
  } catch (const FileError&) {
    return 0;
  }
  file.Set(text);
  fuzz::Require(FormatBal(ReadBal(file.Path())) == text, "a written problem is read back as the same");
  return 0;
}
