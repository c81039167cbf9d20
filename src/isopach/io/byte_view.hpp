// ByteView: the bytes of a file by their place, whether they are in memory or are read as they are asked for.
#pragma once
#include <cstddef>
#include <cstring>
#include <span>

#include "isopach/base/array.hpp"
#include "isopach/io/input_file.hpp"

namespace isopach {

/// A view: what it looks at must outlive it. Places beyond size() must not be asked for.
class ByteView {
 public:
  ByteView() = default;
  explicit ByteView(std::span<const char> bytes) : memory_(bytes) {}
  /// Of a regular file, which is not read as a whole.
  explicit ByteView(const InputFile& file) : file_(&file) {}

  [[nodiscard]] std::size_t size() const { return file_ != nullptr ? file_->size() : memory_.size(); }
  [[nodiscard]] bool in_memory() const { return file_ == nullptr; }

  void copy(std::size_t at, std::size_t length, char* into) const {
    if (file_ != nullptr)
      file_->read_at(at, length, into);
    else if (length > 0)
      std::memcpy(into, memory_.data() + at, length);
  }
  /// The bytes themselves where they are in memory, else a copy in `scratch`: valid until that changes.
  [[nodiscard]] std::span<const char> get(std::size_t at, std::size_t length, Array<char>& scratch) const {
    if (file_ == nullptr) return memory_.subspan(at, length);
    scratch.resize(length);
    file_->read_at(at, length, scratch.data());
    return {scratch.data(), length};
  }
  template <class T>
  [[nodiscard]] T number(std::size_t at) const {
    T value;
    copy(at, sizeof value, reinterpret_cast<char*>(&value));
    return value;
  }

 private:
  std::span<const char> memory_;
  const InputFile* file_ = nullptr;
};

}  // namespace isopach
