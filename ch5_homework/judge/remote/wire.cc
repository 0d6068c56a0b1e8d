#include "ch5_homework/judge/remote/wire.h"

#include <unistd.h>

#include <cerrno>
#include <cstring>

namespace ch5::homework {
namespace {

constexpr char kMagic[] = "ch5!";
constexpr size_t kHeader = 8;

}  // namespace

// ---- numbers ---------------------------------------------------------------------------------------------------------

void Writer::Int(int64_t value) { bytes_.append(reinterpret_cast<const char*>(&value), sizeof(value)); }

void Writer::String(const std::string& text) {
  Int(static_cast<int64_t>(text.size()));
  bytes_ += text;
}

void Writer::Matrix(const MatXX& A) {
  Int(A.rows());
  Int(A.cols());
  bytes_.append(reinterpret_cast<const char*>(A.data()), static_cast<size_t>(A.size()) * sizeof(double));
}

const char* Reader::Take(size_t size) {
  if (size > Left()) throw WireError("it ends too early");
  at_ += size;
  return bytes_.data() + at_ - size;
}

int64_t Reader::Int() {
  int64_t value;
  std::memcpy(&value, Take(sizeof(value)), sizeof(value));
  return value;
}

bool Reader::Bool() {
  const int64_t value = Int();
  if (value != 0 && value != 1) throw WireError(std::to_string(value) + " in place of 0 or 1");
  return value == 1;
}

size_t Reader::Count() {
  const int64_t count = Int();
  if (count < 0 || static_cast<uint64_t>(count) > Left()) throw WireError("a count is " + std::to_string(count));
  return static_cast<size_t>(count);
}

std::string Reader::String() {
  const size_t size = Count();
  return std::string(Take(size), size);
}

MatXX Reader::Matrix() {
  const int64_t rows = Int(), columns = Int();
  if (rows < 0 || columns < 0 || rows > kMaxRows || columns > kMaxRows) {
    throw WireError("a matrix is said to have " + std::to_string(rows) + " rows and " + std::to_string(columns) +
                    " columns");
  }
  const size_t size = static_cast<size_t>(rows * columns) * sizeof(double);
  const char* numbers = Take(size);
  MatXX A(rows, columns);
  if (size > 0) std::memcpy(A.data(), numbers, size);
  return A;
}

void Reader::End() const {
  if (Left() > 0) throw WireError(std::to_string(Left()) + " bytes too many");
}

// ---- values ----------------------------------------------------------------------------------------------------------

void Writer::All(const Values& values) {
  Int(static_cast<int64_t>(values.size()));
  values.ForEach([this](const std::string& name, const Values::Value& value) {
    String(name);
    Int(value.Matrix() != nullptr);
    if (value.Matrix() != nullptr) Matrix(*value.Matrix());
    if (value.Word() != nullptr) String(*value.Word());
  });
}

void Reader::All(Values* values) {
  const size_t count = Count();
  if (count > kMaxValues) throw WireError(std::to_string(count) + " values");
  for (size_t k = 0; k < count; ++k) {
    const std::string name = String();
    if (values->Has(name)) throw WireError("two values of one name");
    if (Bool()) {
      values->Put(name, Matrix());
    } else {
      values->Put(name, String());
    }
  }
}

// ---- frames ----------------------------------------------------------------------------------------------------------

std::string Framed(const std::string& payload) {
  if (payload.size() > kMaxFrame) throw WireError("a frame of " + std::to_string(payload.size()) + " bytes");
  const auto length = static_cast<uint32_t>(payload.size());
  std::string frame(kMagic, 4);
  frame.append(reinterpret_cast<const char*>(&length), sizeof(length));
  return frame + payload;
}

std::optional<std::string> TakeFrame(std::string* bytes) {
  if (bytes->compare(0, std::min<size_t>(4, bytes->size()), kMagic, std::min<size_t>(4, bytes->size())) != 0) {
    throw WireError("no frame begins there");
  }
  if (bytes->size() < kHeader) return std::nullopt;
  uint32_t length;
  std::memcpy(&length, bytes->data() + 4, sizeof(length));
  if (length > kMaxFrame) throw WireError("a frame of " + std::to_string(length) + " bytes");
  if (bytes->size() < kHeader + length) return std::nullopt;
  std::string payload = bytes->substr(kHeader, length);
  bytes->erase(0, kHeader + length);
  return payload;
}

bool ReadFrame(int descriptor, std::string* payload) {
  std::string bytes;
  size_t wanted = kHeader;
  for (;;) {
    char buffer[1 << 16];
    const ssize_t got = read(descriptor, buffer, std::min(sizeof(buffer), wanted - bytes.size()));
    if (got < 0 && errno == EINTR) continue;
    if (got <= 0) return false;
    bytes.append(buffer, static_cast<size_t>(got));
    if (bytes.size() < wanted) continue;
    if (auto whole = TakeFrame(&bytes)) {
      *payload = std::move(*whole);
      return true;
    }
    uint32_t length;
    std::memcpy(&length, bytes.data() + 4, sizeof(length));
    wanted = kHeader + length;
  }
}

bool WriteFrame(int descriptor, const std::string& payload) {
  const std::string frame = Framed(payload);
  for (size_t sent = 0; sent < frame.size();) {
    const ssize_t wrote = write(descriptor, frame.data() + sent, frame.size() - sent);
    if (wrote < 0 && errno == EINTR) continue;
    if (wrote <= 0) return false;
    sent += static_cast<size_t>(wrote);
  }
  return true;
}

}  // namespace ch5::homework
