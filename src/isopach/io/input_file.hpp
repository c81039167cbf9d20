// InputFile: the bytes of a file, pipe or device, opened once and read once into memory of our own, or piece by piece.
// Nothing is mapped: a file that another program cuts or changes must not change under a parser that has checked its
// counts.
#pragma once
#include <cstdint>
#include <memory>
#include <span>
#include <string>

#include "isopach/base/context.hpp"

namespace isopach {

/// Most bytes that one input may have: a limit of the process, as those of the shell are. 0: half of the memory that it
/// may use, since the points of a file need about as much room as its bytes. To be set before anything is read.
void set_max_input(std::uint64_t bytes);
[[nodiscard]] std::uint64_t max_input();

class InputFile {
 public:
  /// Opens `path` and reads the head of a regular file, all of anything else; waits for what comes through a pipe.
  /// Throws Interrupted if the user asks to stop, InputError in one line if there is no such file, it is a folder, may
  /// not be read, is empty or larger than max_input().
  InputFile(const std::string& path, const Context& context);
  ~InputFile();
  InputFile(const InputFile&) = delete;
  InputFile& operator=(const InputFile&) = delete;

  /// Can it be opened again by its path? Not what comes through a pipe.
  [[nodiscard]] bool is_regular() const { return regular_; }
  /// The first bytes, 4096 at most.
  [[nodiscard]] std::span<const char> head() const;
  /// All bytes; read by the first call. Throws InputError if a regular file was cut or changed since it was opened.
  [[nodiscard]] std::span<const char> bytes();
  /// Bytes of a regular file when it was opened; of anything else, bytes that came.
  [[nodiscard]] std::uint64_t size() const { return regular_ ? size_ : used_; }
  /// Time of the last change, in nanoseconds since 1970.
  [[nodiscard]] std::int64_t modified_ns() const { return changed_s_ * 1000000000 + changed_ns_; }
  /// Copies `length` bytes from place `at` of a regular file that has them; max_input() does not bound it. Any thread
  /// may call it. Throws as bytes().
  void read_at(std::uint64_t at, std::size_t length, char* into) const;

 private:
  struct Release {
    void operator()(char* p) const;
  };

  void read_stream();
  void read_regular(std::uint64_t end);
  void grow(std::uint64_t size);
  std::size_t read_some(std::uint64_t most);
  [[noreturn]] void fail_to_read(int error) const;
  [[noreturn]] void fail_cut(std::uint64_t end) const;
  void check_unchanged() const;
  void refuse_larger() const;

  std::string path_;
  const Context& context_;
  int descriptor_ = -1;
  bool regular_ = false;
  std::uint64_t size_ = 0, used_ = 0, room_ = 0;
  std::int64_t changed_s_ = 0, changed_ns_ = 0;  ///< time of the last change when it was opened
  std::unique_ptr<char, Release> data_;
};

}  // namespace isopach
