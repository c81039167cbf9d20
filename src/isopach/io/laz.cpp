#include "isopach/io/laz.hpp"

#include <fmt/format.h>
#include <laszip/laszip_api.h>

#include <algorithm>
#include <cerrno>
#include <cstring>
#include <fstream>
#include <istream>
#include <optional>
#include <sstream>
#include <streambuf>

#include "isopach/base/array.hpp"
#include "isopach/base/error.hpp"
#include "isopach/base/parallel.hpp"
#include "isopach/io/output_file.hpp"

namespace isopach {
namespace {

constexpr std::size_t waveform_length = 29;

// A handle of LASzip. Nothing it does may be trusted to leave an object behind, so every call is checked.
class Handle {
 public:
  Handle() {
    if (laszip_create(&pointer_) != 0) throw Error(ExitCode::internal, "LASzip could not be started");
  }
  ~Handle() {
    if (reading_) laszip_close_reader(pointer_);
    if (writing_) laszip_close_writer(pointer_);
    laszip_destroy(pointer_);
  }
  Handle(const Handle&) = delete;
  Handle& operator=(const Handle&) = delete;

  [[nodiscard]] laszip_POINTER get() const { return pointer_; }
  [[nodiscard]] bool open_reader(const std::string& path) {
    laszip_BOOL compressed = 0;
    reading_ = laszip_open_reader(pointer_, path.c_str(), &compressed) == 0;
    return reading_;
  }
  /// The stream must outlive the reader.
  [[nodiscard]] bool open_reader(std::istream& stream) {
    laszip_BOOL compressed = 0;
    reading_ = laszip_open_reader_stream(pointer_, stream, &compressed) == 0;
    return reading_;
  }
  /// The stream must outlive the writer, and be looked at when it is closed: LASzip does not notice lost writes.
  [[nodiscard]] bool open_writer(std::ostream& stream) {
    writing_ = laszip_open_writer_stream(pointer_, stream, 1, 0) == 0;
    return writing_;
  }
  [[nodiscard]] bool close_writer() {
    writing_ = false;
    return laszip_close_writer(pointer_) == 0;
  }
  [[nodiscard]] std::string error() const {
    char* text = nullptr;
    std::string message = laszip_get_error(pointer_, &text) == 0 && text != nullptr ? text : "unknown failure";
    // LASzip says this of every exception, that of missing memory among them.
    if (message.starts_with("internal error")) message += ": broken, or short of memory";
    for (char& c : message)
      if (static_cast<unsigned char>(c) < ' ') c = ' ';
    return "LASzip: " + message;
  }

 private:
  laszip_POINTER pointer_ = nullptr;
  bool reading_ = false, writing_ = false;
};

// The bytes of a file as a stream that LASzip can read and seek in.
class BytesBuffer : public std::streambuf {
 public:
  explicit BytesBuffer(const ByteView& bytes) : bytes_(bytes) {
    if (bytes.in_memory()) show(0, bytes.size());
  }
  [[nodiscard]] std::size_t position() const { return start_ + static_cast<std::size_t>(gptr() - eback()); }

 protected:
  int_type underflow() override {
    constexpr std::size_t at_once = std::size_t{1} << 18;
    if (position() >= bytes_.size()) return traits_type::eof();
    show(position(), std::min(at_once, bytes_.size() - position()));
    return traits_type::to_int_type(*gptr());
  }
  pos_type seekoff(off_type by, std::ios_base::seekdir from, std::ios_base::openmode) override {
    const auto size = static_cast<off_type>(bytes_.size()), here = static_cast<off_type>(position());
    const off_type at = by + (from == std::ios_base::beg ? 0 : from == std::ios_base::end ? size : here);
    if (at < 0 || at > size) return pos_type(off_type(-1));
    const auto place = static_cast<std::size_t>(at);
    const auto shown = static_cast<std::size_t>(egptr() - eback());
    if (place >= start_ && place <= start_ + shown)
      setg(eback(), eback() + (place - start_), egptr());
    else
      start_ = place, setg(nullptr, nullptr, nullptr);
    return pos_type(at);
  }
  pos_type seekpos(pos_type at, std::ios_base::openmode mode) override {
    return seekoff(off_type(at), std::ios_base::beg, mode);
  }

 private:
  void show(std::size_t at, std::size_t length) {
    const std::span<const char> part = bytes_.get(at, length, scratch_);
    char* const begin = const_cast<char*>(part.data());  // streams that only read take it so
    setg(begin, begin, begin + part.size());
    start_ = at;
  }

  ByteView bytes_;
  std::size_t start_ = 0;  // of what is shown
  Array<char> scratch_;
};

// Items of LASzip's own record, by type: 0 extra bytes, 6-9 point/time/colour/waveform of formats 0-5, 10-14 of 6-10.
// LASzip sizes its buffers by them, so they must be those of the point format.
std::size_t item_length(int type, std::size_t stated) {
  switch (type) {
    case 0:
    case 14:
      return stated;
    case 6:
      return 20;
    case 7:
      return 8;
    case 8:
      return 6;
    case 9:
    case 13:
      return waveform_length;
    case 10:
      return 30;
    case 11:
      return 6;
    case 12:
      return 8;
    default:
      return 0;
  }
}

std::vector<int> items_of(int format) {
  switch (format) {
    case 0:
      return {6};
    case 1:
      return {6, 7};
    case 2:
      return {6, 8};
    case 3:
      return {6, 7, 8};
    case 4:
      return {6, 7, 9};
    case 5:
      return {6, 7, 8, 9};
    case 6:
      return {10};
    case 7:
      return {10, 11};
    case 8:
      return {10, 12};
    case 9:
      return {10, 13};
    default:
      return {10, 12, 13};
  }
}

const LasRecord* laszip_record(const LasFile& file) {
  for (const LasRecord& record : file.records)
    if (record.user == "laszip encoded" && record.id == 22204) return &record;
  return nullptr;
}

[[noreturn]] void fail(const std::string& path, const std::string& cause) {
  throw InputError(fmt::format("{}: {}: get the file again", path, cause));
}

bool is_layered(const LasFile& file) { return get_le<std::uint16_t>(laszip_record(file)->data.data()) == 3; }

void check_items(const LasFile& file, const std::string& path) {
  const LasRecord* const record = laszip_record(file);
  if (record == nullptr || record->data.size() < 34)
    fail(path, "the points are compressed, but LASzip's record is missing");
  const char* const data = record->data.data();
  const std::size_t items = get_le<std::uint16_t>(data + 32);
  if (record->data.size() < 34 + 6 * items) fail(path, "LASzip's record is cut short");
  std::vector<int> types;
  std::size_t length = 0;
  for (std::size_t i = 0; i < items; ++i) {
    const int type = get_le<std::uint16_t>(data + 34 + 6 * i);
    const std::size_t stated = get_le<std::uint16_t>(data + 36 + 6 * i);
    const int version = get_le<std::uint16_t>(data + 38 + 6 * i);
    const bool known = is_layered(file) ? version == 3 || version == 4 : version == 1 || version == 2;
    if (stated == 0 || stated != item_length(type, stated) || !known) fail(path, "LASzip's record is damaged");
    length += stated;
    if (type != 0 && type != 14) types.push_back(type);
  }
  const int compressor = get_le<std::uint16_t>(data), coder = get_le<std::uint16_t>(data + 2);
  if (compressor < 1 || compressor > 3 || coder != 0) fail(path, "LASzip's record names an unknown compressor");
  if (is_layered(file) != (file.format >= 6)) fail(path, "LASzip's record names a compressor of other point formats");
  if (length != file.record_length || types != items_of(file.format))
    fail(path, "LASzip's record and the LAS header describe different points");
}

// The chunk at a place of the file as its own head tells it; no points if there is none. `head`: bytes of the head.
LazChunk chunk_at(const LasFile& file, std::size_t at, std::size_t layers, std::size_t head, Array<char>& scratch) {
  const std::size_t size = file.bytes.size();
  if (at > size || size - at < head) return {at, head, 0};
  const char* const numbers = file.bytes.get(at, head, scratch).data() + file.record_length;
  LazChunk chunk{at, head, get_le<std::uint32_t>(numbers)};
  for (std::size_t i = 1; i <= layers; ++i) chunk.length += get_le<std::uint32_t>(numbers + 4 * i);
  if (chunk.length > size - at) chunk.points = 0;
  return chunk;
}

std::size_t layers_of(const LasFile& file) {
  const std::size_t colours = file.format == 7 ? 1 : file.format == 8 || file.format == 10 ? 2 : 0;
  const std::size_t extra = file.record_length - las_record_length[static_cast<std::size_t>(file.format)];
  return 9 + colours + (file.format >= 9 ? 1 : 0) + extra;
}

std::size_t head_of_chunk(const LasFile& file) { return file.record_length + 4 + 4 * layers_of(file); }

// The chunks of a layered file (point formats 6 to 10), found without the table at the end: a chunk is one plain point,
// the number of points, the length of each layer, and the layers.
std::vector<LazChunk> find_chunks(const LasFile& file, const std::string& path) {
  const std::size_t layers = layers_of(file), head = head_of_chunk(file);
  std::vector<LazChunk> chunks;
  Array<char> scratch;
  std::size_t at = file.points_at + 8;
  for (std::size_t found = 0; found < file.count;) {
    LazChunk chunk = chunk_at(file, at, layers, head, scratch);
    if (chunk.points == 0)
      fail(path, fmt::format("the header promises {} points, {} are there in whole chunks", file.count, found));
    const std::size_t points = chunk.points;
    chunk.points = std::min(points, file.count - found);
    chunks.push_back(chunk);
    found += points;
    at += chunk.length;
  }
  return chunks;
}

// A file of its own for one chunk: LASzip trusts the table of chunks without checking it, and here it meets none.
std::string file_of_chunk(const LasFile& file, const LazChunk& chunk) {
  constexpr std::size_t header = 375;
  const std::span<const char> record = laszip_record(file)->whole;
  std::string bytes(header, '\0');
  file.bytes.copy(0, std::min(header, file.bytes.size()), bytes.data());
  char* const h = bytes.data();
  h[25] = 4;
  put_le(h + 94, static_cast<std::uint16_t>(header));
  put_le(h + 96, static_cast<std::uint32_t>(header + record.size()));
  put_le<std::uint32_t>(h + 100, 1);
  put_le<std::uint32_t>(h + 107, 0);
  put_le<std::uint64_t>(h + 227, 0), put_le<std::uint64_t>(h + 235, 0), put_le<std::uint32_t>(h + 243, 0);
  put_le<std::uint64_t>(h + 247, chunk.points);
  bytes.append(record.data(), record.size());
  put_le(bytes.data() + header + 54 + 12, static_cast<std::uint32_t>(chunk.points));  // points in a chunk
  const std::uint64_t no_table = bytes.size();
  bytes.append(reinterpret_cast<const char*>(&no_table), sizeof no_table);
  const std::size_t before = bytes.size();
  bytes.resize(before + chunk.length);
  file.bytes.copy(chunk.at, chunk.length, bytes.data() + before);
  return bytes;
}

// Where the file says that its table of chunks is: before the points, or at the end if it was written to a stream.
std::int64_t place_of_table(const LasFile& file) {
  const auto table = file.bytes.number<std::int64_t>(file.points_at);
  return table == -1 ? file.bytes.number<std::int64_t>(file.bytes.size() - 8) : table;
}

// LASzip takes memory for as many records as the header says, and as many chunks as the table says; each of these needs
// room for a first, uncompressed point.
void check_table(const LasFile& file, const std::string& path) {
  if (get_le<std::uint32_t>(file.head.data() + 100) != file.records.size())
    fail(path, "the header promises more variable length records than there are");
  const LasRecord* const record = laszip_record(file);
  if (get_le<std::uint16_t>(record->data.data()) < 2) return;  // not in chunks
  const std::size_t size = file.bytes.size();
  if (size - file.points_at < 8) fail(path, "the compressed points are cut short");
  const std::int64_t table = place_of_table(file);
  const auto at = static_cast<std::uint64_t>(table);
  if (table < 0 || at < file.points_at || at > size || size - at < 8)
    fail(path,
         fmt::format("the table of compressed chunks is at byte {} of a file of {}: it is cut short", table, size));
  const std::size_t chunks = file.bytes.number<std::uint32_t>(at + 4);
  if (chunks > (at - file.points_at) / file.record_length)
    fail(path, fmt::format("the table of compressed chunks promises {} of them, more than the file can hold", chunks));
}

void pack_legacy(const laszip_point& p, char* record) {
  record[14] = static_cast<char>(p.return_number | p.number_of_returns << 3 | p.scan_direction_flag << 6 |
                                 p.edge_of_flight_line << 7);
  record[15] =
      static_cast<char>(p.classification | p.synthetic_flag << 5 | p.keypoint_flag << 6 | p.withheld_flag << 7);
  put_le(record + 16, p.scan_angle_rank);
  put_le(record + 17, p.user_data);
  put_le(record + 18, p.point_source_ID);
}

void pack_modern(const laszip_point& p, char* record) {
  record[14] = static_cast<char>(p.extended_return_number | p.extended_number_of_returns << 4);
  record[15] = static_cast<char>(p.extended_classification_flags | p.extended_scanner_channel << 4 |
                                 p.scan_direction_flag << 6 | p.edge_of_flight_line << 7);
  put_le(record + 16, p.extended_classification);
  put_le(record + 17, p.user_data);
  put_le(record + 18, p.extended_scan_angle);
  put_le(record + 20, p.point_source_ID);
  put_le(record + 22, p.gps_time);
}

// Lays a point of LASzip out as the record of an uncompressed file.
void pack(const laszip_point& p, int format, std::size_t length, char* record) {
  put_le(record, p.X), put_le(record + 4, p.Y), put_le(record + 8, p.Z), put_le(record + 12, p.intensity);
  const bool modern = format >= 6;
  std::size_t at = modern ? 30 : 20;
  modern ? pack_modern(p, record) : pack_legacy(p, record);
  if (format == 1 || (format >= 3 && format <= 5)) put_le(record + at, p.gps_time), at += 8;
  const std::size_t colours = format == 2 || format == 3 || format == 5 || format == 7 ? 3
                              : format == 8 || format == 10                            ? 4
                                                                                       : 0;
  std::memcpy(record + at, p.rgb, 2 * colours), at += 2 * colours;
  if (format == 4 || format == 5 || format >= 9)
    std::memcpy(record + at, p.wave_packet, waveform_length), at += waveform_length;
  const std::size_t extra = std::min(length - at, static_cast<std::size_t>(std::max(p.num_extra_bytes, 0)));
  if (extra > 0) std::memcpy(record + at, p.extra_bytes, extra);
  std::memset(record + at + extra, 0, length - at - extra);
}

// A reader of the whole file that can be set to any point: one of several that decompress side by side.
class PlacedReader {
 public:
  explicit PlacedReader(const ByteView& bytes) : buffer_(bytes), stream_(&buffer_) {}
  /// Empty, or what is wrong.
  [[nodiscard]] std::string open() {
    const bool good = handle_.open_reader(stream_) && laszip_get_point_pointer(handle_.get(), &point_) == 0;
    return good ? "" : handle_.error();
  }
  [[nodiscard]] std::string seek(std::size_t point) {
    return laszip_seek_point(handle_.get(), static_cast<laszip_I64>(point)) == 0 ? "" : handle_.error();
  }
  [[nodiscard]] bool next() { return laszip_read_point(handle_.get()) == 0; }
  [[nodiscard]] const laszip_point& point() const { return *point_; }
  [[nodiscard]] std::string error() const { return handle_.error(); }
  [[nodiscard]] std::size_t position() const { return buffer_.position(); }

 private:
  BytesBuffer buffer_;
  std::istream stream_;
  Handle handle_;
  laszip_point* point_ = nullptr;
};

// A run of points that one task decompresses into its place among the records.
struct Run {
  std::size_t first, points;
  std::size_t begin = 0, end = 0;  // bytes of the file that were decompressed
  std::string failure;             // empty: none
};

// Points in a chunk where all but the last have as many; 0: not in chunks, or in chunks of any size.
std::size_t points_in_chunks(const LasFile& file) {
  const char* const record = laszip_record(file)->data.data();
  if (is_layered(file) || get_le<std::uint16_t>(record) != 2) return 0;
  const std::size_t points = get_le<std::uint32_t>(record + 12);
  if (points == 0 || points >= file.count) return 0;
  const std::size_t chunks = file.bytes.number<std::uint32_t>(static_cast<std::size_t>(place_of_table(file)) + 4);
  return chunks == (file.count + points - 1) / points ? points : 0;
}

}  // namespace

// Decompresses batch by batch. A batch is as many whole chunks as fit, shared out over the threads; where the file does
// not come in chunks, or in huge ones, so many points of the one reader that goes through them.
struct LazReader::State {
  State(const std::string& name, const LasFile& las)
      : path(name),
        file(las),
        batch(std::clamp<std::size_t>(batch_bytes / las.record_length, 1, batch_points)),
        total(las.count),
        buffer(las.bytes),
        whole(&buffer) {}
  static constexpr std::size_t batch_points = std::size_t{1} << 19, batch_bytes = std::size_t{64} << 20;

  std::string path;
  const LasFile& file;
  std::size_t batch;             // most points at a time
  std::vector<LazChunk> chunks;  // empty unless layered
  std::size_t total = 0;         // points of all of them, or of the file
  std::size_t regular = 0;       // points in each chunk of a file of regular chunks, 0: any other file
  std::size_t next_chunk = 0, left = 0, done = 0;
  std::size_t reached = 0;  // where the last batch of regular chunks ended in the file
  BytesBuffer buffer;
  std::istream whole;          // the file
  std::istringstream chunked;  // of one chunk
  std::optional<Handle> laszip;
  laszip_point* point = nullptr;
  std::vector<std::unique_ptr<PlacedReader>> readers;
  Array<char> records;
  std::size_t given = 0, ready = 0;  // records of the buffer that were handed out, and all of them

  [[noreturn]] void fail_at(std::size_t at, const std::string& cause) const {
    fail(path, fmt::format("point {} of {} cannot be decompressed ({})", at + 1, total, cause));
  }

  void open() {
    laszip.emplace();
    bool good = true;
    if (chunks.empty()) {
      good = laszip->open_reader(whole);
      left = file.count;
    } else {
      const LazChunk& chunk = chunks[next_chunk++];
      chunked = std::istringstream(file_of_chunk(file, chunk));
      good = laszip->open_reader(chunked);
      left = chunk.points;
    }
    if (!good || laszip_get_point_pointer(laszip->get(), &point) != 0) fail(path, laszip->error());
  }

  /// The next points of the reader that goes through them: as many as it gave.
  std::size_t read_on(char* into) {
    if (left == 0) open();
    const std::size_t count = std::min(left, batch);
    for (std::size_t i = 0; i < count; ++i) {
      if (laszip_read_point(laszip->get()) != 0) fail_at(done + i, laszip->error());
      pack(*point, file.format, file.record_length, into + i * file.record_length);
    }
    left -= count;
    return count;
  }

  /// The layered chunks that fit into a batch; none if the next alone does not.
  [[nodiscard]] std::size_t layered_chunks() const {
    std::size_t points = 0, n = 0;
    while (next_chunk + n < chunks.size() && points + chunks[next_chunk + n].points <= batch)
      points += chunks[next_chunk + n++].points;
    return n;
  }

  void decompress(const LazChunk& chunk, Run& run, char* into) const {
    std::istringstream stream(file_of_chunk(file, chunk));
    Handle handle;
    laszip_point* read = nullptr;
    if (!handle.open_reader(stream) || laszip_get_point_pointer(handle.get(), &read) != 0) {
      run.failure = handle.error();
      return;
    }
    for (std::size_t i = 0; i < run.points; ++i) {
      if (laszip_read_point(handle.get()) != 0) {
        run.first += i;
        run.failure = handle.error();
        return;
      }
      pack(*read, file.format, file.record_length, into + i * file.record_length);
    }
  }

  std::size_t read_layered(std::size_t count, char* into) {
    std::vector<Run> runs;
    std::size_t points = 0;
    for (std::size_t i = 0; i < count; ++i) {
      runs.push_back({done + points, chunks[next_chunk + i].points, 0, 0, {}});
      points += runs.back().points;
    }
    for_blocks(count, 1, [&](std::size_t i, std::size_t) {
      decompress(chunks[next_chunk + i], runs[i], into + (runs[i].first - done) * file.record_length);
    });
    check(runs);
    next_chunk += count;
    return points;
  }

  void decompress(PlacedReader& reader, Run& run, char* into) const {
    run.failure = reader.seek(run.first);
    run.begin = reader.position();
    for (std::size_t i = 0; run.failure.empty() && i < run.points; ++i) {
      if (reader.next()) {
        pack(reader.point(), file.format, file.record_length, into + i * file.record_length);
        continue;
      }
      run.first += i;
      run.failure = reader.error();
    }
    run.end = reader.position();
  }

  std::size_t read_regular(char* into) {
    while (readers.size() < static_cast<std::size_t>(thread_count())) {
      readers.push_back(std::make_unique<PlacedReader>(file.bytes));
      if (const std::string cause = readers.back()->open(); !cause.empty()) fail(path, cause);
    }
    const std::size_t points = std::min(batch / regular * regular, file.count - done);
    const std::size_t all = (points + regular - 1) / regular;
    std::vector<Run> runs;
    for (std::size_t i = 0, from = 0; i < readers.size(); ++i) {
      const std::size_t to = (i + 1) * all / readers.size();
      if (to == from) continue;
      const std::size_t last = std::min(to * regular, points);
      runs.push_back({done + from * regular, last - from * regular, 0, 0, {}});
      from = to;
    }
    for_blocks(runs.size(), 1, [&](std::size_t i, std::size_t) {
      decompress(*readers[i], runs[i], into + (runs[i].first - done) * file.record_length);
    });
    check(runs);
    // LASzip believes its table of chunks: each run must begin where the one before it ended.
    for (const Run& run : runs) {
      if (run.begin != reached) fail_at(run.first, "the table of compressed chunks does not fit the points");
      reached = run.end;
    }
    return points;
  }

  void check(const std::vector<Run>& runs) const {
    for (const Run& run : runs)
      if (!run.failure.empty()) fail_at(run.first, run.failure);
  }

  /// Decompresses the next batch behind the records that are ready.
  void more() {
    const std::size_t length = file.record_length;
    if (ready > given) std::memmove(records.data(), records.data() + given * length, (ready - given) * length);
    ready -= given, given = 0;
    records.resize((ready + std::min(batch, total - done)) * length);
    char* const into = records.data() + ready * length;
    std::size_t count = 0;
    if (const std::size_t n = left == 0 ? layered_chunks() : 0; n > 0)
      count = read_layered(n, into);
    else
      count = regular > 0 ? read_regular(into) : read_on(into);
    done += count, ready += count;
  }
};

LazReader::LazReader(const std::string& path, const LasFile& file) : state_(std::make_unique<State>(path, file)) {
  State& state = *state_;
  check_items(file, path);
  if (is_layered(file)) {
    state.chunks = find_chunks(file, path);
    return;
  }
  check_table(file, path);
  if (const std::size_t points = points_in_chunks(file); 2 * points <= state.batch && thread_count() > 1)
    state.regular = points;
  state.reached = file.points_at + 8;
}

LazReader::LazReader(const std::string& path, const LasFile& file, std::vector<LazChunk> chunks)
    : state_(std::make_unique<State>(path, file)) {
  check_items(file, path);
  const std::size_t layers = layers_of(file), head = head_of_chunk(file);
  Array<char> scratch;
  state_->total = 0;
  for (const LazChunk& chunk : chunks) {
    const LazChunk there = chunk_at(file, chunk.at, layers, head, scratch);
    if (there.points != chunk.points || there.length != chunk.length)
      fail(path, fmt::format("the index of chunks does not fit the chunk at byte {}", chunk.at));
    state_->total += chunk.points;
  }
  state_->chunks = std::move(chunks);
}

LazReader::~LazReader() = default;

const char* LazReader::next(std::size_t count) {
  State& state = *state_;
  while (state.ready - state.given < count) state.more();
  const char* const records = state.records.data() + state.given * state.file.record_length;
  state.given += count;
  return records;
}

bool has_layered_chunks(const LasFile& file) {
  const LasRecord* const record = file.compressed ? laszip_record(file) : nullptr;
  return record != nullptr && record->data.size() >= 2 && is_layered(file) && file.format >= 6;
}

void compress_las(const std::string& las, const std::string& laz, std::size_t count, const Context& context) {
  std::ofstream out(laz, std::ios::binary);
  if (!out) fail_to_write(laz, std::strerror(errno));
  Handle reader, writer;
  const auto check = [&](bool good, const Handle& handle) {
    if (!good) fail_to_write(laz, handle.error());
  };
  check(reader.open_reader(las), reader);
  laszip_header* header = nullptr;
  laszip_point* point = nullptr;
  check(laszip_get_header_pointer(reader.get(), &header) == 0, reader);
  check(laszip_get_point_pointer(reader.get(), &point) == 0, reader);
  check(laszip_set_header(writer.get(), header) == 0, writer);
  check(laszip_preserve_generating_software(writer.get(), 1) == 0, writer);
  check(laszip_request_native_extension(writer.get(), 1) == 0, writer);
  check(writer.open_writer(out), writer);
  constexpr std::size_t block = 65536;
  for (std::size_t i = 0; i < count; ++i) {
    if (i % block == 0) context.step("write", static_cast<double>(i) / static_cast<double>(count));
    check(laszip_read_point(reader.get()) == 0, reader);
    check(laszip_set_point(writer.get(), point) == 0, writer);
    check(laszip_write_point(writer.get()) == 0, writer);
  }
  check(writer.close_writer(), writer);
  out.close();
  if (!out) fail_to_write(laz, std::strerror(errno));
}

}  // namespace isopach
