#include "isopach/io/point_blocks.hpp"

#include <algorithm>

#include "isopach/base/parallel.hpp"
#include "isopach/io/formats.hpp"
#include "isopach/io/point_source.hpp"

namespace isopach {
namespace {

// A file that is read at once, handed on in parts.
class WholeSource : public PointSource {
 public:
  explicit WholeSource(Cloud cloud) : whole_(std::move(cloud)) {}

  void begin(Cloud& cloud) override {
    cloud.format = whole_.format, cloud.crs = whole_.crs;
    cloud.unit = whole_.unit, cloud.vertical_unit = whole_.vertical_unit;
    for (const Attribute& attribute : whole_.attributes) cloud.attributes.push_back({attribute.name, {}});
  }
  bool append(Cloud& cloud, std::size_t most, const Context&) override {
    const std::size_t count = std::min(most, whole_.points.size() - done_);
    if (count == 0) return false;
    const auto part = [&](auto& to, const auto& from) {
      const auto first = from.begin() + static_cast<std::ptrdiff_t>(done_);
      to.insert(to.end(), first, first + static_cast<std::ptrdiff_t>(count));
    };
    part(cloud.points, whole_.points);
    for (std::size_t k = 0; k < cloud.attributes.size(); ++k)
      part(cloud.attributes[k].values, whole_.attributes[k].values);
    done_ += count;
    return true;
  }
  void end(Cloud& cloud) override {
    cloud.notes.insert(cloud.notes.end(), whole_.notes.begin(), whole_.notes.end());
    cloud.nodata = whole_.nodata, cloud.grid = whole_.grid;
  }

 private:
  Cloud whole_;
  std::size_t done_ = 0;
};

// A source that reads piece by piece; null where the format has none.
std::unique_ptr<PointSource> piecewise(const InputFile& file, const std::string& path, const ReadOptions& options) {
  const ByteView bytes(file);
  switch (find_format(path, file.head(), file.size())) {
    case Format::las:
      return las_source(bytes, path, options);
    case Format::ply:
      return ply_source(bytes, path, options);
    case Format::text:
      return text_source(bytes, path, options);
    default:
      return nullptr;
  }
}

std::unique_ptr<PointSource> open_source(InputFile& file, const std::string& path, const ReadOptions& options,
                                         const Context& context) {
  std::unique_ptr<PointSource> source;
  if (file.is_regular()) source = piecewise(file, path, options);
  if (!source) source = std::make_unique<WholeSource>(read_opened(file, path, options, context));
  return source;
}

void clear(Cloud& block) {
  block.points.clear();
  for (Attribute& attribute : block.attributes) attribute.values.clear();
}

void crop(Cloud& block, const PlanBox& box) {
  std::size_t kept = 0;
  for (std::size_t i = 0; i < block.points.size(); ++i) {
    if (!box.has(block.points[i])) continue;
    block.points[kept] = block.points[i];
    for (Attribute& attribute : block.attributes) attribute.values[kept] = attribute.values[i];
    ++kept;
  }
  block.points.resize(kept);
  for (Attribute& attribute : block.attributes) attribute.values.resize(kept);
}

Cloud hand_on(PointSource& source, Cloud block, std::size_t most, const PlanBox* box, const TakeBlock& take,
              const Context& context) {
  source.begin(block);
  Cloud rest = block;
  for (bool more = true; more;) {
    clear(block);
    do more = source.append(block, most - block.points.size(), context);
    while (more && block.points.size() < most);
    if (box != nullptr) crop(block, *box);
    if (!block.points.empty()) take(block);
  }
  source.end(rest);
  return rest;
}

Cloud read_blocks(const std::string& path, const PlanBox* box, const ReadOptions& options, const Context& context,
                  const TakeBlock& take, std::size_t most) {
  context.check();
  Cloud rest;
  run_with_threads(context, [&] {
    InputFile file(path, context);
    ReadOptions points = options;
    points.faces = false;
    const std::unique_ptr<PointSource> source = open_source(file, path, points, context);
    if (box != nullptr) source->leave_out_beyond(*box);
    Cloud block;
    block.path = path;
    rest = hand_on(*source, std::move(block), std::max<std::size_t>(most, 1), box, take, context);
  });
  return rest;
}

}  // namespace

Cloud read_all(PointSource& source, const Context& context) {
  Cloud cloud;
  source.begin(cloud);
  cloud.points.reserve(source.sure());
  for (Attribute& attribute : cloud.attributes) attribute.values.reserve(source.sure());
  while (source.append(cloud, all_points, context)) {
  }
  source.end(cloud);
  return cloud;
}

Cloud for_each_block(const std::string& path, const ReadOptions& options, const Context& context, const TakeBlock& take,
                     std::size_t most) {
  return read_blocks(path, nullptr, options, context, take, most);
}

Cloud for_each_block_in(const std::string& path, const PlanBox& box, const ReadOptions& options, const Context& context,
                        const TakeBlock& take, std::size_t most) {
  return read_blocks(path, &box, options, context, take, most);
}

FileSummary summarise(const std::string& path, const ReadOptions& options, const Context& context) {
  context.check();
  const InputFile file(path, context);
  FileSummary summary;
  summary.path = path;
  summary.bytes = file.size(), summary.modified_ns = file.modified_ns();
  ReadOptions points = options;
  points.faces = false;
  const std::unique_ptr<PointSource> source = file.is_regular() ? piecewise(file, path, points) : nullptr;
  if (!source) {
    summary.format = format_name(find_format(path, file.head(), file.size()));
    return summary;
  }
  Cloud known;
  source->begin(known);
  summary.format = known.format, summary.crs = known.crs;
  summary.unit = known.unit, summary.vertical_unit = known.vertical_unit;
  for (const Attribute& attribute : known.attributes) summary.attributes.push_back(attribute.name);
  source->describe(summary);
  return summary;
}

}  // namespace isopach
