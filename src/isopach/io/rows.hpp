// Rows of numbers as text, one point a line: the body of XYZ, CSV, PTS, PTX, ascii PLY and ascii PCD files.
// Lines are counted first and then parsed straight into their place, both in parallel over fixed chunks of bytes cut at
// line ends, so the result does not depend on the number of threads. Cost: two passes over the bytes.
#pragma once
#include <string>
#include <vector>

#include "isopach/io/byte_view.hpp"
#include "isopach/io/scan.hpp"

namespace isopach {

struct RowFormat {
  char separator = ' ';          ///< ',' ';' '\t' or ' ' = any run of blanks and tabs
  bool comments = true;          ///< skip lines that start with # % ! or //
  std::size_t lines_before = 0;  ///< line ends before the text, for the number of a line in messages
  std::vector<int> targets;  ///< per column up to the last wanted: 0, 1, 2 = x, y, z; 3 + k = attribute k; -1 = skipped
};

/// The column targets for x, y, z at the given columns and the attributes at theirs.
[[nodiscard]] std::vector<int> column_targets(const std::array<int, 3>& axes, const std::vector<int>& attributes);

/// Separator of a line of data: ';' if there is one, else tab, comma, or blanks.
[[nodiscard]] char find_separator(std::string_view line);

/// The fields of a line, without the blanks and quotes around them.
[[nodiscard]] std::vector<std::string_view> split(std::string_view line, char separator);

/// Offset just behind the `rows`-th line that is neither blank nor a comment; npos if there are fewer.
[[nodiscard]] std::size_t offset_after_rows(std::string_view text, std::size_t rows, bool comments);

/// Appends a point (and a value per attribute of the cloud) for every line of `file` from `begin` to `end` that is
/// neither blank nor a comment. With ';' or tab between fields a number may have a decimal comma (a note says so).
/// Returns the number of rows. Throws InputError with the number of the first line that does not parse.
std::size_t parse_rows(std::string_view file, std::size_t begin, std::size_t end, const RowFormat& format,
                       const std::string& name, Cloud& cloud);

/// The rows of a text one lot after the other: all at once where it is in memory, else from pieces of the file of some
/// MiB, each cut at a line end. Oracle: parse_rows of the whole.
class RowStream {
 public:
  /// From place `from` to the end; `lines_before` line ends stand before it. The bytes must outlive the stream.
  RowStream(const ByteView& bytes, std::size_t from, std::size_t lines_before, RowFormat format, std::string name);
  /// Appends the next rows, `most` of them at most; their number, 0 at the end. Throws as parse_rows.
  std::size_t append(Cloud& cloud, std::size_t most);
  /// Share of the text that was read.
  [[nodiscard]] double progress() const;
  /// The note on decimal commas, if there were any.
  void note(Cloud& cloud) const;

 private:
  bool next_piece();

  ByteView bytes_;
  std::size_t at_;  // where the next piece begins
  RowFormat format_;
  std::string name_;
  bool comma_ = false;
  Array<char> scratch_;
  std::string_view rest_;  // of the piece at hand
};

}  // namespace isopach
