// LAS, LAZ and COPC files (ASPRS LAS 1.0 to 1.5, point formats 0 to 10). Plain files are decoded in parallel;
// compressed ones, COPC included, by LASzip from the first point to the last.
#pragma once
#include <array>
#include <span>
#include <string>
#include <string_view>
#include <vector>

#include "isopach/cloud/cloud_view.hpp"
#include "isopach/io/read.hpp"
#include "isopach/io/write.hpp"

namespace isopach {

/// Do the first bytes of a file say that it is LAS, LAZ or COPC?
[[nodiscard]] bool is_las(std::string_view head);

/// Coordinates are X * scale + offset in double precision, as the format defines them. Attributes by name: those of the
/// point format (classification, intensity, return_number, number_of_returns, scan_angle in degrees or ranks of them,
/// user_data, point_source_id, gps_time, red, green, blue, near_infrared, and the flags as 0 or 1) and the extra bytes.
/// Points flagged as withheld are kept, since ids count points of the file; a note says how many there are.
/// Units come from the CRS; where it is absent or silent they stay "unknown".
/// Throws InputError: damaged or cut short, unknown version or format, no points. Oracle:
/// LasTest.CompressedEqualsPlain.
[[nodiscard]] Cloud read_las(const std::string& path, const ReadOptions& options, const Context& context);
/// The same of a file that is in memory; `path` is its name.
[[nodiscard]] Cloud read_las(std::span<const char> bytes, const std::string& path, const ReadOptions& options,
                             const Context& context);

/// Writes LAS 1.4, compressed if the name ends with .laz: point format 6, or 7 if there are colours. They are the
/// formats whose classification has 8 bits and whose CRS is well-known text, and that hold more than 2^32 points. An
/// attribute of the point format goes to its own place if that can hold all its values exactly, any other to extra
/// bytes as doubles. Step of each coordinate: 1e-4 units, or the first finer power of ten down to 1e-9 that loses
/// nothing, or else the finest that 32 bits allow: the error is at most 0.5e-4. Faces are not written. Throws
/// InputError: not finite, or wider than 429 496 units (2^32 steps of 1e-4).
void write_las(const std::string& path, const Cloud& cloud, const Context& context);

/// Was the cloud read from a LAS or LAZ file that can be read again, so that its records can be copied? What came
/// through a pipe cannot.
[[nodiscard]] bool is_las_file(const CloudView& cloud);

/// How a file stores its numbers, for who wants to know what a conversion changed.
struct LasStorage {
  struct Extra {
    std::string name, type;  ///< snake_case; "uint16", "double", …, with "scaled " before it where it has a scale
  };
  int minor = 0, format = 0;  ///< LAS 1.minor, point format
  std::array<double, 3> step{};
  std::vector<Extra> extra;  ///< extra bytes
};
/// Of the header and the descriptors alone. Throws InputError as read_las.
[[nodiscard]] LasStorage las_storage(const std::string& path);

}  // namespace isopach
