// How files come into being: beside their place, whole, on the disk, and only then under their name. Names of what is
// not finished begin with ".isopach-", the process and a random number, so that a later run knows the remains of one
// that was killed.
#pragma once
#include <string>
#include <string_view>

namespace isopach {

/// Every failure to write, with one exit code (1) and one sentence: "out/map.png: cannot be written (No space left on
/// device): make room on the disk, or choose another folder".
[[noreturn]] void fail_to_write(const std::string& path, const std::string& cause);

/// A file written in pieces; a failure throws as fail_to_write of `name`, which is its path if it is empty.
class OutputFile {
 public:
  explicit OutputFile(std::string path, std::string name = "");
  ~OutputFile();
  OutputFile(const OutputFile&) = delete;
  OutputFile& operator=(const OutputFile&) = delete;
  void write(std::string_view bytes);
  void close();

 private:
  std::string name_;
  int descriptor_ = -1;
};

/// `text` to a file, whole or not at all (write_atomically).
void write_text_atomically(const std::string& path, const std::string& text);

/// ".isopach-PID-RANDOM": a name that no other run has.
[[nodiscard]] std::string unfinished_name();
/// Is this the name of an unfinished folder, as unfinished_name gives it?
[[nodiscard]] bool is_unfinished_folder(std::string_view name);
/// A path, or a sentence with paths in it, as the user knows them: without what unfinished_name gave, and without the
/// folder "new" in such a folder, where the command line writes results.
[[nodiscard]] std::string place_of(std::string text);

/// Waits until a file or folder is on the disk; folders on file systems that cannot are passed over. Throws as
/// fail_to_write.
void put_on_disk(const std::string& path);

/// Removes from `folder` the unfinished files of runs that are no more: those of the file `name`, or of any if it is
/// empty. A run that lives holds a lock on its own.
void sweep_unfinished_files(const std::string& folder, std::string_view name);

}  // namespace isopach
