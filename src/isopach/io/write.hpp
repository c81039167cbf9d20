// write_cloud: points (with attributes and faces) to a file, format by extension: .ply (binary little-endian, doubles),
// .xyz/.txt/.csv (shortest round-trip numbers), .las/.laz, .obj, .stl (needs faces), .pcd, .npy.
// Files appear whole or not at all: written beside the target, then renamed.
#pragma once
#include <functional>
#include <span>
#include <string>

#include "isopach/base/context.hpp"
#include "isopach/cloud/cloud_view.hpp"

namespace isopach {

void write_cloud(const std::string& path, const Cloud& cloud, const Context& context);

/// Copies the LAS/LAZ file that `cloud` was read from (is_las_file) to `target` and adds one extra-bytes field (double)
/// per attribute; each attribute has one value per point, in file order. Throws InputError if the points of the file
/// are no longer those of `cloud`: the values would go to others.
void write_las_with_fields(const CloudView& cloud, const std::string& target, std::span<const Attribute> fields,
                           const Context& context);

/// Calls `write(temporary)` with a path beside `target`, puts that file on the disk and renames it to `target`; removes
/// it if `write` throws. Every file the project writes goes through here: output_file.cpp.
void write_atomically(const std::string& target, const std::function<void(const std::string& temporary)>& write);

}  // namespace isopach
