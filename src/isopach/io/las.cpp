#include "isopach/io/las.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <cerrno>
#include <cmath>
#include <cstdio>
#include <cstring>
#include <filesystem>
#include <fstream>
#include <limits>
#include <memory>

#include "isopach/base/parallel.hpp"
#include "isopach/io/copc.hpp"
#include "isopach/io/input_file.hpp"
#include "isopach/io/las_format.hpp"
#include "isopach/io/laz.hpp"
#include "isopach/io/output_file.hpp"
#include "isopach/io/point_source.hpp"
#include "isopach/io/scan.hpp"

namespace isopach {
namespace {

constexpr std::size_t records_at_once = std::size_t{1} << 18, bytes_at_once = std::size_t{64} << 20;
constexpr std::size_t header_1_4 = 375;
constexpr std::size_t name_length = 32;

// The point records of a file in order, wherever they are.
class RecordSource {
 public:
  /// `chunks`: all of them, or those of which the points are wanted.
  RecordSource(const std::string& path, const LasFile& file, std::optional<std::vector<LazChunk>> chunks = {})
      : file_(file) {
    if (chunks)
      laz_ = std::make_unique<LazReader>(path, file, std::move(*chunks));
    else if (file.compressed)
      laz_ = std::make_unique<LazReader>(path, file);
  }
  // The next `count` records, valid until the next call.
  const char* next(std::size_t count) {
    if (laz_) return laz_->next(count);
    const std::size_t at = file_.points_at + done_ * file_.record_length;
    done_ += count;
    return file_.bytes.get(at, count * file_.record_length, scratch_).data();
  }

 private:
  const LasFile& file_;
  std::unique_ptr<LazReader> laz_;
  Array<char> scratch_;
  std::size_t done_ = 0;
};

bool ends_with_laz(const std::string& path) {
  return path.size() >= 4 && lower_case(path.substr(path.size() - 4)) == ".laz";
}

std::vector<LasColumn> wanted_columns(const LasFile& file, const ReadOptions& options,
                                      std::vector<std::string>& notes) {
  std::vector<LasColumn> columns = las_standard_columns(file.format);
  for (LasColumn& extra : las_extra_columns(file, columns, notes)) columns.push_back(std::move(extra));
  const auto unwanted = [&](const LasColumn& column) { return !wanted(options, column.name); };
  columns.erase(std::remove_if(columns.begin(), columns.end(), unwanted), columns.end());
  return columns;
}

std::size_t count_withheld(const LasFile& file, const char* records, std::size_t count) {
  const char bit = file.format >= 6 ? '\x04' : '\x80';
  return reduce_blocks<std::size_t>(
      count, default_block,
      [&](std::size_t begin, std::size_t end) {
        std::size_t n = 0;
        for (std::size_t i = begin; i < end; ++i) n += (records[i * file.record_length + 15] & bit) != 0 ? 1 : 0;
        return n;
      },
      [](std::size_t& total, std::size_t n) { total += n; });
}

class LasSource : public PointSource {
 public:
  LasSource(const ByteView& bytes, const std::string& path, const ReadOptions& options)
      : path_(path), file_(parse_las(bytes, path)), xyz_(las_coordinates(file_)), total_(file_.count) {
    if (file_.count == 0) throw InputError(fmt::format("{}: the file holds no points: choose one that does", path));
    columns_ = wanted_columns(file_, options, file_.notes);
  }

  void begin(Cloud& cloud) override {
    cloud.format = file_.compressed ? "laz" : "las";
    for (const LasColumn& column : columns_) cloud.attributes.push_back({column.name, {}});
    set_crs(cloud, las_crs(file_, path_, crs_notes_));
  }

  // A compressed file proves its count only by being read: until then no more memory than its size warrants.
  [[nodiscard]] std::size_t sure() const override {
    return file_.compressed ? std::min(total_, file_.bytes.size()) : total_;
  }

  bool append(Cloud& cloud, std::size_t most, const Context& context) override {
    if (done_ == total_) return false;
    if (!records_) records_.emplace(path_, file_, std::move(chunks_));
    context.step("read", static_cast<double>(done_) / static_cast<double>(total_));
    const std::size_t at_once = std::clamp<std::size_t>(bytes_at_once / file_.record_length, 1, records_at_once);
    const std::size_t count = std::min({at_once, most, total_ - done_}), first = cloud.points.size();
    const char* const records = records_->next(count);
    cloud.points.resize(first + count);
    for (Attribute& attribute : cloud.attributes) attribute.values.resize(first + count);
    for_each_index(count, [&](std::size_t i) {
      const char* const record = records + i * file_.record_length;
      cloud.points[first + i] = {xyz_[0].load(record), xyz_[1].load(record), xyz_[2].load(record)};
      for (std::size_t k = 0; k < columns_.size(); ++k)
        cloud.attributes[k].values[first + i] = columns_[k].load(record);
    });
    withheld_ += count_withheld(file_, records, count);
    done_ += count;
    return true;
  }

  void end(Cloud& cloud) override {
    std::vector<std::string>& notes = cloud.notes;
    notes.insert(notes.end(), file_.notes.begin(), file_.notes.end());
    if (withheld_ > 0)
      notes.push_back(fmt::format("{} of {} points are flagged as withheld; they are kept", withheld_, total_));
    notes.insert(notes.end(), crs_notes_.begin(), crs_notes_.end());
  }

  void leave_out_beyond(const PlanBox& box) override {
    if (!is_copc(file_)) return;
    chunks_ = copc_chunks(file_, box);
    if (!chunks_) return;  // nobody knows what is where: all are read
    total_ = 0;
    for (const LazChunk& chunk : *chunks_) total_ += chunk.points;
  }

  void describe(FileSummary& summary) const override {
    const auto number = [&](std::size_t at) { return get_le<double>(file_.head.data() + at); };
    summary.points = file_.count;
    summary.bounds =
        FileSummary::Bounds{{number(187), number(203), number(219)}, {number(179), number(195), number(211)}};
  }

 private:
  std::string path_;
  LasFile file_;
  std::array<LasColumn, 3> xyz_;
  std::vector<LasColumn> columns_;
  std::vector<std::string> crs_notes_;
  std::optional<std::vector<LazChunk>> chunks_;  // of a box
  std::optional<RecordSource> records_;
  std::size_t total_, done_ = 0, withheld_ = 0;
};

// ---------------------------------------------------------------------------------------------------------- writing

std::string variable_record(const char* user, std::uint16_t id, const std::string& data) {
  std::string record(54, '\0');
  std::strncpy(record.data() + 2, user, 16);
  put_le(record.data() + 18, id);
  put_le(record.data() + 20, static_cast<std::uint16_t>(data.size()));
  return record + data;
}

std::string extra_bytes_record(const std::string& descriptors, const std::string& path) {
  if (descriptors.size() > 65535)
    throw UsageError(fmt::format("{}: a LAS file holds at most 341 extra fields: keep fewer attributes", path));
  return variable_record("LASF_Spec", 4, descriptors);
}

std::string double_descriptor(const std::string& name, const std::string& path) {
  if (name.empty() || name.size() > name_length)
    throw UsageError(fmt::format("{}: \"{}\" cannot name a LAS field: use 1 to 32 bytes", path, name));
  std::string descriptor(las_descriptor_length, '\0');
  descriptor[2] = 10;  // double
  name.copy(descriptor.data() + 4, name_length);
  return descriptor;
}

// What goes into a new file before and after its points.
struct Frame {
  std::string head;  // header and variable length records
  std::string tail;  // extended variable length records
  std::uint32_t tail_records = 0;
  std::size_t waveforms_in_tail = std::string::npos;
  std::size_t count = 0, record_length = 0;
};

using Fill = std::function<void(std::size_t begin, std::size_t count, char* records)>;

// `name`: that of the file in messages.
void write_plain(const std::string& path, const std::string& name, const Frame& frame, const Fill& fill,
                 const Context& context) {
  OutputFile out(path, name);
  out.write(frame.head);
  Array<char> block;
  for (std::size_t first = 0; first < frame.count; first += records_at_once) {
    context.step("write", static_cast<double>(first) / static_cast<double>(frame.count));
    const std::size_t count = std::min(records_at_once, frame.count - first);
    block.resize(count * frame.record_length);
    fill(first, count, block.data());
    out.write({block.data(), block.size()});
  }
  out.close();
}

void append_tail(const std::string& path, const Frame& frame) {
  if (frame.tail_records == 0) return;
  std::fstream out(path, std::ios::binary | std::ios::in | std::ios::out | std::ios::ate);
  const auto start = static_cast<std::uint64_t>(out.tellp());
  out.write(frame.tail.data(), static_cast<std::streamsize>(frame.tail.size()));
  const auto patch = [&](std::streamoff at, auto value) {
    out.seekp(at);
    out.write(reinterpret_cast<const char*>(&value), sizeof value);
  };
  if (frame.waveforms_in_tail != std::string::npos) patch(227, start + frame.waveforms_in_tail);
  if (frame.head[25] >= 4) patch(235, start), patch(243, frame.tail_records);
  out.close();
  if (!out) fail_to_write(path, std::strerror(errno));
}

void write_frame(const std::string& path, const Frame& frame, const Fill& fill, const Context& context) {
  write_atomically(path, [&](const std::string& temporary) {
    if (ends_with_laz(path)) {
      const std::string plain = temporary + ".las";
      const struct Remover {
        const std::string& name;
        ~Remover() { std::remove(name.c_str()); }
      } remover{plain};
      write_plain(plain, path, frame, fill, context);
      compress_las(plain, temporary, frame.count, context);
    } else {
      write_plain(temporary, path, frame, fill, context);
    }
    append_tail(temporary, frame);
  });
}

struct Axis {
  double scale, offset, min, max;
  [[nodiscard]] double steps(double value) const { return std::nearbyint((value - offset) / scale); }
  [[nodiscard]] double stored(double value) const { return steps(value) * scale + offset; }
};

// The coarsest step from 1e-4 to 1e-9 that loses nothing, or the finest one for which 32 bits hold the extent.
Axis choose_axis(const Cloud& cloud, double Point3::*coordinate, const std::string& path) {
  constexpr double range = 2147483647;
  double low = std::numeric_limits<double>::infinity(), high = -low;
  for (std::size_t i = 0; i < cloud.points.size(); ++i) {
    const double value = cloud.points[i].*coordinate;
    if (!std::isfinite(value))
      throw InputError(fmt::format("{}: point {} is not finite, LAS cannot hold it: write .ply, or drop it", path, i));
    low = std::min(low, value), high = std::max(high, value);
  }
  if (cloud.points.empty()) low = high = 0;
  const double offset = std::floor(low / 2 + high / 2);
  const double rounding = 4 * std::numeric_limits<double>::epsilon() * std::max(std::fabs(low), std::fabs(high));
  Axis best{};
  for (double steps = 1e4; steps <= 1e9; steps *= 10) {
    const Axis axis{1 / steps, offset, low, high};
    if (!(std::max(std::fabs(axis.steps(low)), std::fabs(axis.steps(high))) <= range)) break;
    best = axis;
    const bool exact = std::all_of(cloud.points.begin(), cloud.points.end(), [&](const Point3& p) {
      return std::fabs(axis.stored(p.*coordinate) - p.*coordinate) <= rounding;
    });
    if (exact) break;
  }
  if (best.scale == 0)
    throw InputError(fmt::format("{}: coordinates from {} to {} are too wide for LAS: write .ply", path, low, high));
  best.min = best.stored(low), best.max = best.stored(high);
  return best;
}

bool holds_all(const LasColumn& column, const Attribute& attribute) {
  char record[64] = {};
  return std::all_of(attribute.values.begin(), attribute.values.end(),
                     [&](double value) { return column.store(record, value); });
}

// Where each attribute of a cloud goes in the records of a new file.
struct Layout {
  int format = 6;
  std::vector<std::pair<LasColumn, const Attribute*>> own;
  std::vector<const Attribute*> extra;
};

Layout lay_out(const Cloud& cloud) {
  Layout layout;
  if (cloud.find_attribute("red") && cloud.find_attribute("green") && cloud.find_attribute("blue")) layout.format = 7;
  const std::vector<LasColumn> columns = las_standard_columns(layout.format);
  for (const Attribute& attribute : cloud.attributes) {
    const auto column =
        std::find_if(columns.begin(), columns.end(), [&](const LasColumn& c) { return c.name == attribute.name; });
    if (column != columns.end() && holds_all(*column, attribute))
      layout.own.emplace_back(*column, &attribute);
    else
      layout.extra.push_back(&attribute);
  }
  return layout;
}

void fill_return_counts(const Layout& layout, std::size_t count, char* header) {
  std::array<std::uint64_t, 16> returns{};
  const auto found = std::find_if(layout.own.begin(), layout.own.end(),
                                  [](const auto& entry) { return entry.first.name == "return_number"; });
  if (found == layout.own.end())
    returns[1] = count;
  else
    for (const double value : found->second->values) ++returns[static_cast<std::size_t>(value)];
  for (std::size_t i = 1; i <= 15; ++i) put_le(header + 255 + 8 * (i - 1), returns[i]);
}

std::string new_header(const Layout& layout, const std::array<Axis, 3>& axes, const Frame& frame, std::size_t records,
                       std::size_t records_size) {
  std::string header(header_1_4, '\0');
  char* const h = header.data();
  std::memcpy(h, "LASF", 4);
  put_le<std::uint16_t>(h + 6, 16);  // the CRS is well-known text
  h[24] = 1, h[25] = 4;
  std::strncpy(h + 26, "OTHER", 32), std::strncpy(h + 58, "isopach", 32);
  put_le(h + 94, static_cast<std::uint16_t>(header_1_4));
  put_le(h + 96, static_cast<std::uint32_t>(header_1_4 + records_size));
  put_le(h + 100, static_cast<std::uint32_t>(records));
  h[104] = static_cast<char>(layout.format);
  put_le(h + 105, static_cast<std::uint16_t>(frame.record_length));
  for (std::size_t i = 0; i < 3; ++i) {
    put_le(h + 131 + 8 * i, axes[i].scale), put_le(h + 155 + 8 * i, axes[i].offset);
    put_le(h + 179 + 16 * i, axes[i].max), put_le(h + 187 + 16 * i, axes[i].min);
  }
  put_le<std::uint64_t>(h + 247, frame.count);
  fill_return_counts(layout, frame.count, h);
  return header;
}

void check_length(std::size_t record_length, const std::string& path) {
  if (record_length > 65535)
    throw UsageError(
        fmt::format("{}: point records of {} bytes are too long for LAS: keep fewer attributes", path, record_length));
}

// The records of the source that a copy keeps: not LASzip's own, not the index of COPC (it holds offsets into the
// source), not the descriptors of extra bytes (they are written anew).
bool is_kept(const LasRecord& record) {
  return record.user != "laszip encoded" && record.user != "copc" && !(record.user == "LASF_Spec" && record.id == 4);
}

// Descriptors for the bytes behind the point format that no descriptor names: the new fields come after them.
std::string undescribed(const LasFile& file) {
  std::size_t known = las_record_length[static_cast<std::size_t>(file.format)];
  const std::string all = las_descriptors(file);
  for (std::size_t i = 0; i < all.size(); i += las_descriptor_length) known += las_described_length(all.data() + i);
  std::string descriptors;
  while (known < file.record_length) {
    const std::size_t bytes = std::min<std::size_t>(file.record_length - known, 255);
    std::string descriptor(las_descriptor_length, '\0');
    descriptor[3] = static_cast<char>(bytes);
    descriptors += descriptor;
    known += bytes;
  }
  return descriptors;
}

std::string unused_name(const std::string& name, const std::string& descriptors) {
  const auto taken = [&](const std::string& candidate) {
    for (std::size_t i = 0; i < descriptors.size(); i += las_descriptor_length)
      if (std::string(descriptors.data() + i + 4, strnlen(descriptors.data() + i + 4, name_length)) == candidate)
        return true;
    return false;
  };
  std::string candidate = name;
  for (int i = 2; taken(candidate); ++i) candidate = fmt::format("{}_{}", name, i);
  return candidate;
}

Frame copied_frame(const LasFile& file, std::span<const Attribute> fields, const std::string& target) {
  Frame frame;
  frame.count = file.count;
  frame.record_length = file.record_length + 8 * fields.size();
  check_length(frame.record_length, target);
  std::string descriptors = las_descriptors(file) + undescribed(file);
  for (const Attribute& field : fields) descriptors += double_descriptor(unused_name(field.name, descriptors), target);

  frame.head.assign(file.head.data(), file.header_size);
  std::uint32_t records = 1;
  for (const LasRecord& record : file.records)
    if (is_kept(record)) frame.head.append(record.whole.data(), record.whole.size()), ++records;
  frame.head += extra_bytes_record(descriptors, target);
  for (const LasRecord& record : file.extended) {
    if (!is_kept(record)) continue;
    if (record.at == file.waveforms_at) frame.waveforms_in_tail = frame.tail.size();
    frame.tail.append(record.whole.data(), record.whole.size()), ++frame.tail_records;
  }
  char* const h = frame.head.data();
  put_le(h + 96, static_cast<std::uint32_t>(frame.head.size()));
  put_le(h + 100, records);
  h[104] = static_cast<char>(file.format);
  put_le(h + 105, static_cast<std::uint16_t>(frame.record_length));
  if (file.minor >= 3 && file.header_size >= 235) put_le<std::uint64_t>(h + 227, 0);
  if (file.minor >= 4) put_le<std::uint64_t>(h + 235, 0), put_le<std::uint32_t>(h + 243, 0);
  if (file.minor > 4 && ends_with_laz(target))
    h[25] = 4;  // the newest LASzip writes; what 1.5 appends stays in the header
  return frame;
}

}  // namespace

bool is_las(std::string_view head) { return head.substr(0, 4) == "LASF"; }

Cloud read_las(const std::string& path, const ReadOptions& options, const Context& context) {
  InputFile file(path, context);
  return read_las(file.bytes(), path, options, context);
}

Cloud read_las(std::span<const char> bytes, const std::string& path, const ReadOptions& options,
               const Context& context) {
  LasSource source(ByteView(bytes), path, options);
  Cloud cloud = read_all(source, context);
  cloud.path = path;
  return cloud;
}

std::unique_ptr<PointSource> las_source(const ByteView& bytes, const std::string& path, const ReadOptions& options) {
  return std::make_unique<LasSource>(bytes, path, options);
}

bool is_las_file(const CloudView& cloud) {
  std::error_code none;
  return (cloud.format == "las" || cloud.format == "laz") && std::filesystem::is_regular_file(cloud.path, none);
}

LasStorage las_storage(const std::string& path) {
  constexpr std::array types{"undocumented", "uint8",  "int8",  "uint16", "int16", "uint32",
                             "int32",        "uint64", "int64", "float",  "double"};
  const Context nobody_stops;
  InputFile input(path, nobody_stops);
  const LasFile file = parse_las(input.bytes(), path);
  LasStorage storage{file.minor, file.format, file.scale, {}};
  const std::string all = las_descriptors(file);
  for (std::size_t i = 0; i < all.size(); i += las_descriptor_length) {
    const char* const descriptor = all.data() + i;
    const std::size_t kind = static_cast<unsigned char>(descriptor[2]);
    const bool is_scaled = (static_cast<unsigned char>(descriptor[3]) & 0x18U) != 0 && kind > 0;
    const std::string type = kind == 0 ? types[0] : types[(kind - 1) % 10 + 1];
    storage.extra.push_back({attribute_name(std::string_view(descriptor + 4, strnlen(descriptor + 4, name_length))),
                             (is_scaled ? "scaled " : "") + type});
  }
  return storage;
}

void write_las(const std::string& path, const Cloud& cloud, const Context& context) {
  const Layout layout = lay_out(cloud);
  const std::array<Axis, 3> axes = {choose_axis(cloud, &Point3::x, path), choose_axis(cloud, &Point3::y, path),
                                    choose_axis(cloud, &Point3::z, path)};
  Frame frame;
  frame.count = cloud.points.size();
  const std::size_t base = las_record_length[static_cast<std::size_t>(layout.format)];
  frame.record_length = base + 8 * layout.extra.size();
  check_length(frame.record_length, path);

  std::string records, descriptors;
  std::size_t record_count = 0;
  if (const std::string wkt = wkt_of_crs(cloud.crs, path); !wkt.empty() && wkt.size() < 65535)
    records += variable_record("LASF_Projection", 2112, wkt + '\0'), ++record_count;
  for (const Attribute* attribute : layout.extra) descriptors += double_descriptor(attribute->name, path);
  if (!descriptors.empty()) records += extra_bytes_record(descriptors, path), ++record_count;
  frame.head = new_header(layout, axes, frame, record_count, records.size()) + records;

  const Fill fill = [&](std::size_t first, std::size_t count, char* block) {
    for_each_index(count, [&](std::size_t i) {
      char* const record = block + i * frame.record_length;
      const Point3& p = cloud.points[first + i];
      std::memset(record, 0, base);
      put_le(record, static_cast<std::int32_t>(axes[0].steps(p.x)));
      put_le(record + 4, static_cast<std::int32_t>(axes[1].steps(p.y)));
      put_le(record + 8, static_cast<std::int32_t>(axes[2].steps(p.z)));
      record[14] = 0x11;  // return 1 of 1, unless the cloud says otherwise
      for (const auto& [column, attribute] : layout.own)
        if (!column.store(record, attribute->values[first + i])) throw Error(ExitCode::internal, "LAS column overflow");
      for (std::size_t k = 0; k < layout.extra.size(); ++k)
        put_le(record + base + 8 * k, layout.extra[k]->values[first + i]);
    });
  };
  write_frame(path, frame, fill, context);
}

void write_las_with_fields(const CloudView& cloud, const std::string& target, std::span<const Attribute> fields,
                           const Context& context) {
  const std::string& source = cloud.path;
  InputFile input(source, context);
  const LasFile file = parse_las(input.bytes(), source);
  const auto check_changed = [&](bool changed) {
    if (changed)
      throw InputError(fmt::format("{}: was changed since it was read: start again when it is whole", source));
  };
  check_changed(cloud.points.size() != file.count);
  for (const Attribute& field : fields)
    if (field.values.size() != file.count)
      throw InputError(fmt::format("{}: it holds {} points, the field {} has {} values: give one value for each point",
                                   source, file.count, field.name, field.values.size()));
  const Frame frame = copied_frame(file, fields, target);
  const std::array<LasColumn, 3> xyz = las_coordinates(file);
  RecordSource records(source, file);
  const Fill fill = [&](std::size_t first, std::size_t count, char* block) {
    const char* const old = records.next(count);
    const auto copy = [&](std::size_t begin, std::size_t end) {
      bool changed = false;
      for (std::size_t i = begin; i < end; ++i) {
        const char* const from = old + i * file.record_length;
        char* const record = block + i * frame.record_length;
        changed |= cloud.points[first + i] != Point3{xyz[0].load(from), xyz[1].load(from), xyz[2].load(from)};
        std::memcpy(record, from, file.record_length);
        for (std::size_t k = 0; k < fields.size(); ++k)
          put_le(record + file.record_length + 8 * k, fields[k].values[first + i]);
      }
      return changed;
    };
    check_changed(reduce_blocks<int>(count, default_block, copy, [](int& all, int part) { all |= part; }) != 0);
  };
  write_frame(target, frame, fill, context);
}

}  // namespace isopach
