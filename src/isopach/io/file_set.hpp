// Several files as one scan: a folder, a pattern, a list, or a catalogue of tiles.
#pragma once
#include <string>
#include <vector>

#include "isopach/base/context.hpp"
#include "isopach/cloud/cloud.hpp"
#include "isopach/io/read.hpp"

namespace isopach {

/// The files that a word names, sorted by path:
///   a file               itself, unseen
///   a folder             the files in it whose extension is that of a scan (is_scan_name), not those in folders below
///   a pattern            '2012/*.laz': what the shell would make of * ? [ ]; a file that has such a name goes first
///   list.txt             one file, folder, pattern or catalogue a line, relative to the list; # begins a comment. A list
///                        is told from a text of points by its first line that is neither blank nor a comment: it ends
///                        with the extension of a scan or catalogue, or names a file or folder
///   catalogue.vpc, .json virtual point cloud or other STAC 1.0 text: FeatureCollection, Feature (an item), or the links
///                        of a Catalog or Collection to items; the asset "data", else all assets whose role is "data",
///                        else those whose name is that of a scan; hrefs relative to the catalogue, or file://
/// Throws UsageError (exit 2): nothing matches, no scan in the folder. Throws InputError (exit 3), which names list and
/// entry: a file that is not there, one that is named twice (by any path), a list that contains itself, an address
/// (http://, s3://: download it), not JSON or not STAC. Cost: of names and texts alone; no scan is opened.
[[nodiscard]] std::vector<std::string> files_of(const std::string& what);

/// Does a word name more than a single scan: a folder, a pattern, a list or a catalogue?
[[nodiscard]] bool is_file_set(const std::string& what);

/// Is the extension that of a format that is read (.las, .laz, .ply, .xyz, .csv, .tif, …)? Any case.
[[nodiscard]] bool is_scan_name(const std::string& path);

/// Throws InputError (exit 3), which names both files, unless a second file has the CRS and the units of the first: what
/// is not known is no contradiction beside a CRS, but units must be the same.
struct FileSystemOfUnits {
  std::string path, unit, vertical_unit, crs;
};
void check_same_system(const FileSystemOfUnits& first, const FileSystemOfUnits& other);

/// All files as one cloud: points in the order of the files, attributes that all of them have, unit and CRS of the
/// first, no faces, and the notes of each. Of one file it is read_cloud. `name` is the path of the cloud, its format
/// "set". Throws as read_cloud and check_same_system; InputError if more than @max-input in all.
[[nodiscard]] Cloud read_set(const std::vector<std::string>& files, const std::string& name, const ReadOptions& options,
                             const Context& context);

/// read_set of files_of: a scan by whatever names it.
[[nodiscard]] Cloud read_scan(const std::string& what, const ReadOptions& options, const Context& context);

}  // namespace isopach
