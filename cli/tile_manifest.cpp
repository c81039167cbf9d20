// JOB/manifest.json, and what it says of inputs and tiles.
#include <fmt/format.h>
#include <sys/stat.h>

#include <cerrno>
#include <cstring>
#include <fstream>
#include <nlohmann/json.hpp>
#include <utility>

#include "cli/tile_job.hpp"
#include "isopach/base/error.hpp"
#include "isopach/compare/stages.hpp"
#include "isopach/io/output_file.hpp"

namespace isopach::cli {
namespace fs = std::filesystem;
namespace {

constexpr const char* schema = "isopach.tiles/1";

using Json = nlohmann::ordered_json;

Json of(const Point3& p) { return Json::array({p.x, p.y, p.z}); }
Point3 point_of(const Json& j) { return {j.at(0).get<double>(), j.at(1).get<double>(), j.at(2).get<double>()}; }
Json of(const Box3& box) { return box.empty() ? Json() : Json::array({of(box.min), of(box.max)}); }
Box3 box_of(const Json& j) {
  Box3 box;
  if (!j.is_null()) box.min = point_of(j.at(0)), box.max = point_of(j.at(1));
  return box;
}

Json of(const std::vector<Point2>& points) {
  Json all = Json::array();
  for (const Point2& p : points) all.push_back({p.x, p.y});
  return all;
}

Json of(const JobScan& s) {
  const Cleaning& c = s.extent.cleaning;
  Json files = Json::array();
  for (const FileStamp& f : s.files)
    files.push_back({{"path", f.path}, {"bytes", f.bytes}, {"modified_ns", f.modified_ns}});
  Json broken = Json::array();
  for (const BrokenFile& f : s.broken) broken.push_back({{"path", f.path}, {"why", f.why}});
  return {{"name", s.name},
          {"format", s.format},
          {"unit", s.unit},
          {"vertical_unit", s.vertical_unit},
          {"crs", s.crs},
          {"notes", s.notes},
          {"nodata", s.nodata},
          {"is_raster", s.is_raster},
          {"points", c.points},
          {"dropped", {{"nonfinite", c.dropped_nonfinite}, {"class", c.dropped_class}, {"crop", c.dropped_crop}}},
          {"kept", of(s.extent.kept)},
          {"finite", of(s.extent.finite)},
          {"hull", of(s.hull)},
          {"files", files},
          {"broken", broken}};
}

JobScan scan_of(const Json& j) {
  JobScan s;
  j.at("name").get_to(s.name), j.at("format").get_to(s.format), j.at("unit").get_to(s.unit);
  j.at("vertical_unit").get_to(s.vertical_unit), j.at("crs").get_to(s.crs), j.at("notes").get_to(s.notes);
  j.at("nodata").get_to(s.nodata), j.at("is_raster").get_to(s.is_raster);
  Cleaning& c = s.extent.cleaning;
  j.at("points").get_to(c.points);
  const Json& dropped = j.at("dropped");
  dropped.at("nonfinite").get_to(c.dropped_nonfinite), dropped.at("class").get_to(c.dropped_class);
  dropped.at("crop").get_to(c.dropped_crop);
  s.extent.kept = box_of(j.at("kept")), s.extent.finite = box_of(j.at("finite"));
  for (const Json& p : j.at("hull")) s.hull.push_back({p.at(0).get<double>(), p.at(1).get<double>()});
  for (const Json& f : j.at("files"))
    s.files.push_back(
        {f.at("path").get<std::string>(), f.at("bytes").get<std::uint64_t>(), f.at("modified_ns").get<std::int64_t>()});
  for (const Json& f : j.at("broken"))
    s.broken.push_back({f.at("path").get<std::string>(), f.at("why").get<std::string>()});
  return s;
}

Json of(const std::vector<PointRun>& runs) {
  Json all = Json::array();
  for (const PointRun& run : runs) all.push_back({run.first, run.count});
  return all;
}

std::vector<PointRun> runs_of(const Json& j) {
  std::vector<PointRun> runs;
  for (const Json& run : j) runs.push_back({run.at(0).get<std::uint64_t>(), run.at(1).get<std::uint64_t>()});
  return runs;
}

Json of(const Job& job) {
  Json tiles = Json::array();
  for (const JobTile& t : job.tiles)
    tiles.push_back({{"level", t.square.level},
                     {"prefix", t.square.prefix},
                     {"points", t.square.points},
                     {"a", of(t.runs[0])},
                     {"b", of(t.runs[1])}});
  const Frame& f = job.frame;
  return {{"schema", schema},
          {"words", job.words},
          {"pose", job.pose.m},
          {"memory", job.memory},
          {"inputs", {of(job.scan[0]), of(job.scan[1])}},
          {"frame",
           {{"origin", of(f.origin)},
            {"rotation", f.rotation},
            {"box", of(f.box)},
            {"curve", {f.curve.min.x, f.curve.min.y, f.curve.scale}}}},
          {"tiles", tiles}};
}

std::string id_of(const std::string& text) {
  std::uint64_t hash = 0xcbf29ce484222325;
  for (const char c : text) hash = (hash ^ static_cast<unsigned char>(c)) * 0x100000001b3;
  return fmt::format("{:016x}", hash);
}

}  // namespace

CloudView JobScan::header() const {
  CloudView cloud;
  cloud.path = name, cloud.format = format, cloud.unit = unit;
  cloud.vertical_unit = vertical_unit, cloud.crs = crs;
  cloud.notes = notes;
  return cloud;
}

fs::path Job::tile_file(std::size_t k, const char* ending) const {
  return folder / "tiles" / fmt::format("{:06d}.{}", k, ending);
}

bool Job::is_done(std::size_t k) const {
  std::error_code error;
  return fs::is_regular_file(tile_file(k, "part"), error);
}

bool Job::is_raster(std::size_t k, const CompareOptions& options) const {
  return scan[k].is_raster && stages::keeps_raster(frame, k == 1 ? options.pose : Pose{});
}

void write_manifest(Job& job) {
  const std::string text = of(job).dump(1, ' ', false, Json::error_handler_t::replace);
  job.id = id_of(text);
  write_text_atomically((job.folder / "manifest.json").string(), text + "\n");
}

Job read_job(const fs::path& folder, const Context& context) {
  context.check();
  const fs::path path = folder / "manifest.json";
  std::ifstream file(path, std::ios::binary);
  if (!file)
    throw UsageError(
        fmt::format("{}: there is no job: plan one (isopach tile plan A B -o {})", folder.string(), folder.string()));
  const std::string text((std::istreambuf_iterator<char>(file)), std::istreambuf_iterator<char>());
  try {
    const Json json = Json::parse(text);
    if (json.at("schema") != schema) throw InputError("");
    Job job;
    job.folder = folder;
    job.id = id_of(text.substr(0, text.find_last_not_of('\n') + 1));
    json.at("words").get_to(job.words), json.at("pose").get_to(job.pose.m), json.at("memory").get_to(job.memory);
    for (std::size_t k = 0; k < 2; ++k) job.scan[k] = scan_of(json.at("inputs").at(k));
    const Json& frame = json.at("frame");
    job.frame.origin = point_of(frame.at("origin"));
    frame.at("rotation").get_to(job.frame.rotation);
    job.frame.box = box_of(frame.at("box"));
    const Json& curve = frame.at("curve");
    job.frame.curve = {{curve.at(0).get<double>(), curve.at(1).get<double>()}, curve.at(2).get<double>()};
    for (const Json& t : json.at("tiles")) {
      JobTile tile;
      t.at("level").get_to(tile.square.level), t.at("prefix").get_to(tile.square.prefix);
      t.at("points").get_to(tile.square.points);
      tile.runs = {runs_of(t.at("a")), runs_of(t.at("b"))};
      if (tile.square.level < 0 || tile.square.level > 32) throw InputError("");
      job.tiles.push_back(std::move(tile));
    }
    return job;
  } catch (const std::exception&) {
    throw InputError(path.string() + ": this is no manifest of a job, or it is damaged: plan the job again");
  }
}

void check_inputs(const Job& job) {
  for (const JobScan& scan : job.scan)
    for (const FileStamp& file : scan.files) {
      struct stat about {};
      if (::stat(file.path.c_str(), &about) != 0)
        throw InputError(
            fmt::format("{}: it is gone ({}), and the job was planned with it", file.path, std::strerror(errno)));
      const std::int64_t changed = std::int64_t{about.st_mtim.tv_sec} * 1'000'000'000 + about.st_mtim.tv_nsec;
      if (static_cast<std::uint64_t>(about.st_size) != file.bytes || changed != file.modified_ns)
        throw InputError(file.path +
                         ": it has changed since the job was planned: plan the job again (isopach tile plan)");
    }
}

}  // namespace isopach::cli
