// Several files as one scan: a folder, a pattern, a list, or a catalogue of tiles.
#pragma once
#include <string>
#include <vector>

#include "isopach/base/context.hpp"
#include "isopach/cloud/cloud.hpp"
#include "isopach/io/read.hpp"

namespace isopach {

/// The files that a word names, sorted by their canonical paths, so that the order does not depend on how they were
/// named:
///   - A file: itself, unseen; also a pipe, and what is not there: whoever reads it says so.
///   - A folder: the scans in it by their extensions, not those in folders below. Files .txt and .csv, which may be
///     anything, are left out: a pattern names them.
///   - A pattern, '2012/*.laz': what a shell makes of * ? [ ]. A file that has such a name goes first.
///   - A list, .txt: one file, folder, pattern, list or catalogue a line, relative to the list; # begins a comment. It
///     is told from a text of points by its first line that is neither blank nor a comment: that is no row of numbers,
///     and ends with the extension of a scan or a catalogue, or names what is there.
///   - A catalogue, .vpc or .json: virtual point cloud or other STAC 1.0 text, that is a FeatureCollection, a Feature
///     (an item), or the links "item" and "child" of a Catalog or Collection. Of an item the asset "data", else assets
///     with the role "data", else those that are scans by their extension; hrefs are relative to the catalogue. A .json
///     file without "stac_version" is none: it is a file.
///
/// Throws InputError (exit 3): a pattern that nothing matches, a folder without scans or with a result of isopach; of a
/// list or catalogue, which is named with the entry, a file that is not there or is named twice (by any path), a list
/// that contains itself, an address (https://, s3://), what is no JSON or no STAC. Cost: of names and of these texts
/// alone; no scan is opened. Oracle: FileSet.* (tests/io/file_set_test.cpp).
[[nodiscard]] std::vector<std::string> files_of(const std::string& what);

/// Is a word more than the name of one scan: a folder, a pattern, a list or a catalogue?
[[nodiscard]] bool is_file_set(const std::string& what);

/// Is the extension that of a format that is read (.las, .laz, .ply, .xyz, .txt, .csv, .tif, …)? Any case.
[[nodiscard]] bool is_scan_name(const std::string& path);

/// What a file says about its coordinates, as in Cloud.
struct ScanSystem {
  std::string path, unit = "unknown", vertical_unit = "unknown", crs;
};

/// Throws InputError (exit 3), which names both files, if they contradict one another: CRS that are not the same, or
/// units that are known and differ. What `all` does not know it takes from `other`.
void join_systems(ScanSystem& all, const ScanSystem& other);

/// The notes of one file of a set, as read_cloud and for_each_block give them.
struct FileNotes {
  std::string path;
  std::vector<std::string> notes;
};

/// Those of all files: equal ones once, with the first file and the number of others, 20 at most. Of one file as they
/// are.
[[nodiscard]] std::vector<std::string> join_notes(const std::vector<FileNotes>& files);

/// All files as one cloud: points in the order of the files, the attributes that all of them have, the unit and CRS
/// that join_systems finds, no faces, and the notes of all, equal ones once. `name` is its path, "set" its format. Of
/// one file it is read_cloud of that. Throws as read_cloud and join_systems; InputError if the files are larger than
/// @max-input together.
[[nodiscard]] Cloud read_set(const std::vector<std::string>& files, const std::string& name, const ReadOptions& options,
                             const Context& context);

}  // namespace isopach
