// How much memory a run may use, for estimates that are made before it is taken, and how much a piece of work took.
#pragma once
#include <cstdint>
#include <optional>
#include <string>

namespace isopach {

/// In bytes: the memory of the machine, of the control group and of the process, the least of them; what others use of
/// it is not subtracted.
[[nodiscard]] std::uint64_t usable_memory();

/// The largest resident size of the process since this was made. One at a time: the system keeps one mark, which a new
/// one puts back to the size at hand.
class PeakMemory {
 public:
  PeakMemory();
  /// In bytes; nothing where the system does not tell (no /proc), or cannot put the mark back and it was passed before:
  /// never the peak of earlier work. Test: PeakMemory.* in tests/base/memory_test.cpp.
  [[nodiscard]] std::optional<std::uint64_t> bytes() const;

 private:
  std::optional<std::uint64_t> before_;  ///< a mark that could not be put back; it tells once it is passed
};

/// "3.2 GB", "500 MB" or "5000 bytes".
[[nodiscard]] std::string bytes_in_words(std::uint64_t bytes);

}  // namespace isopach
