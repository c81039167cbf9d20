// How much memory a run may use, for estimates that are made before it is taken.
#pragma once
#include <cstdint>
#include <string>

namespace isopach {

/// In bytes: the memory of the machine, of the control group and of the process, the least of them; what others use of
/// it is not subtracted.
[[nodiscard]] std::uint64_t usable_memory();

/// "3.2 GB", "500 MB" or "5000 bytes".
[[nodiscard]] std::string bytes_in_words(std::uint64_t bytes);

}  // namespace isopach
