// LASzip behind two doors: compressed point records in, plain point records out, and a plain LAS file made into a
// compressed one.
#pragma once
#include <memory>
#include <string>
#include <vector>

#include "isopach/base/context.hpp"
#include "isopach/io/las_format.hpp"

namespace isopach {

/// A chunk of a file of layered chunks (point formats 6 to 10): its bytes, and how many points they hold.
struct LazChunk {
  std::size_t at, length, points;
};

/// Reads the points of a LAZ or COPC file in order, as the records an uncompressed file would hold. Files of layered
/// chunks (point formats 6 to 10) or of regular ones are decompressed by all threads, a batch of chunks at a time.
/// Test: LasTest.CompressedEqualsPlain and LasTest.EveryPointOfALargeCompressedFileIsRead, for 1, 2 and 7 threads.
class LazReader {
 public:
  /// Throws InputError if the compressed points contradict the header. `file` must outlive the reader.
  LazReader(const std::string& path, const LasFile& file);
  /// The points of these chunks alone, in their order. Throws InputError, here or later, where one is no chunk of as
  /// many points and bytes.
  LazReader(const std::string& path, const LasFile& file, std::vector<LazChunk> chunks);
  ~LazReader();
  LazReader(const LazReader&) = delete;
  LazReader& operator=(const LazReader&) = delete;
  /// The next `count` records of record_length bytes, valid until the next call; no more than there are. Throws
  /// InputError if the file is cut short or its structure is damaged. Damage inside the compressed codes, which have no
  /// checksum, goes unnoticed or, since LASzip does not check what it decodes, may even end the program.
  const char* next(std::size_t count);

 private:
  struct State;
  std::unique_ptr<State> state_;
};

/// Are the points compressed in layered chunks? False also where LASzip's record is missing or damaged.
[[nodiscard]] bool has_layered_chunks(const LasFile& file);

/// Compresses the `count` points of `las` (plain, without extended records) into `laz`. Throws Error if it cannot be
/// written.
void compress_las(const std::string& las, const std::string& laz, std::size_t count, const Context& context);

}  // namespace isopach
