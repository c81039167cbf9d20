// Parts as bytes: what tiles leave in files for whoever joins them. Numbers as this machine keeps them.
#pragma once
#include <cstddef>
#include <span>
#include <string>

#include "isopach/tiles/part.hpp"

namespace isopach {

/// A part, with what its scans' nodes tell of layers. `job` stands in the head: parts of other jobs are refused.
[[nodiscard]] std::string bytes_of(const Part& part, const std::string& job);
/// InputError, which begins with `name`, for bytes that are no such part of this job, or were cut or changed.
[[nodiscard]] Part part_of(std::span<const char> bytes, const std::string& job, const std::string& name);

/// Final cells, so that CellPart can refer to the bytes where they lie (aligned to 8).
[[nodiscard]] std::string bytes_of(const FinalCells& cells, const std::string& job);
/// Refers to `bytes`, which must live. InputError as above; the checksum of cells is not looked at, their sizes are.
[[nodiscard]] CellPart cells_of(std::span<const char> bytes, const std::string& job, const std::string& name,
                                std::size_t first_node);

}  // namespace isopach
