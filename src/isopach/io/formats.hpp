// Which format a file has, and its reader.
#pragma once
#include <cstdint>
#include <span>
#include <string>

#include "isopach/io/input_file.hpp"
#include "isopach/io/read.hpp"

namespace isopach {

enum class Format { text, ply, obj, stl, pcd, las, raster };

/// By the first bytes, 4096 at most, of a file of `size` bytes, then by the extension. Throws InputError: a format that
/// is not read.
[[nodiscard]] Format find_format(const std::string& path, std::span<const char> head, std::uint64_t size);

/// As Cloud::format says it; of LAS "las", compressed or not.
[[nodiscard]] std::string format_name(Format format);

/// read_cloud of a file that is open.
[[nodiscard]] Cloud read_opened(InputFile& file, const std::string& path, const ReadOptions& options,
                                const Context& context);

}  // namespace isopach
