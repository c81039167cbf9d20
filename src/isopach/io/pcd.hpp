// PCD (Point Cloud Library): ascii, binary and binary_compressed; fields of any type, size and count, x y z in any
// case. A viewpoint other than the identity is not applied; a note says so. Faces do not exist in PCD. InputError: no
// DATA line, no x, y or z, no points, sizes beyond the file, compressed data that do not decode. binary_compressed: LZF
// (M. Lehmann), and field after field instead of point after point. Oracle test: PcdTest.RoundTrip*.
#pragma once
#include <span>
#include <string>

#include "isopach/io/read.hpp"

namespace isopach {

[[nodiscard]] Cloud parse_pcd(std::span<const char> bytes, const std::string& name, const ReadOptions& options,
                              const Context& context);

/// True if the text begins as the header of a PCD file.
[[nodiscard]] bool is_pcd(std::span<const char> head);

/// Decodes an LZF stream; false if it is damaged or does not give exactly output.size() bytes.
[[nodiscard]] bool decode_lzf(std::span<const char> input, std::span<char> output);

}  // namespace isopach
