// The files that a catalogue names: a virtual point cloud (.vpc) or other STAC 1.0 text.
#pragma once
#include <string>
#include <vector>

namespace isopach {

/// The hrefs of scans in a FeatureCollection or a Feature, or of catalogues in a Catalog or Collection, as they are
/// written; `path` is the name in messages. Of an item the asset "data", else assets with the role "data", else those
/// that are scans by their extension. Throws InputError: no JSON, nested too deeply, no STAC, an item without a scan.
[[nodiscard]] std::vector<std::string> stac_hrefs(const std::string& text, const std::string& path);

/// Without "file://" before it; anything else as it is.
[[nodiscard]] std::string path_of_href(const std::string& href);

/// With "%20" and the like made into the bytes they stand for.
[[nodiscard]] std::string decoded(const std::string& href);

/// A name made fit for a one-line message: control characters are shown as ?, and no more than 200 bytes.
[[nodiscard]] std::string printable(const std::string& text);

}  // namespace isopach
