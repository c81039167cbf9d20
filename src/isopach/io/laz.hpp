// LASzip behind two doors: compressed point records in, plain point records out, and a plain LAS file made into a
// compressed one.
#pragma once
#include <memory>
#include <string>

#include "isopach/base/context.hpp"
#include "isopach/io/las_format.hpp"

namespace isopach {

/// Reads the points of a LAZ or COPC file one after another, as the records an uncompressed file would hold.
class LazReader {
 public:
  /// Throws InputError if the compressed points contradict the header. `file` must outlive the reader.
  LazReader(const std::string& path, const LasFile& file);
  ~LazReader();
  LazReader(const LazReader&) = delete;
  LazReader& operator=(const LazReader&) = delete;
  /// Decompresses the next point into `record` (record_length bytes). Throws InputError if the file is cut short or its
  /// structure is damaged. Damage inside the compressed codes, which have no checksum, goes unnoticed or, since LASzip
  /// does not check what it decodes, may even end the program.
  void next(char* record);

 private:
  struct State;
  std::unique_ptr<State> state_;
};

/// Compresses the `count` points of `las` (plain, without extended records) into `laz`. Throws Error if it cannot be
/// written.
void compress_las(const std::string& las, const std::string& laz, std::size_t count, const Context& context);

}  // namespace isopach
