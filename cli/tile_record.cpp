#include "cli/tile_record.hpp"

#include <fmt/chrono.h>
#include <fmt/format.h>
#include <sys/resource.h>
#include <unistd.h>

#include <array>
#include <ctime>
#include <fstream>
#include <nlohmann/json.hpp>

#include "isopach/base/parallel.hpp"
#include "isopach/io/output_file.hpp"

namespace isopach::cli {
namespace {

using Json = nlohmann::ordered_json;

constexpr const char* schema = "isopach.tile/1";

double cpu_seconds() {
  rusage used{};
  ::getrusage(RUSAGE_SELF, &used);
  const auto seconds = [](const timeval& t) {
    return static_cast<double>(t.tv_sec) + 1e-6 * static_cast<double>(t.tv_usec);
  };
  return seconds(used.ru_utime) + seconds(used.ru_stime);
}

double seconds_since(std::chrono::steady_clock::time_point start) {
  return std::chrono::duration<double>(std::chrono::steady_clock::now() - start).count();
}

std::string host_name() {
  std::array<char, 256> name{};
  return ::gethostname(name.data(), name.size() - 1) == 0 ? name.data() : "";
}

std::string duration_in_words(double seconds) {
  if (seconds < 90) return fmt::format("{:.0f} s", seconds);
  if (seconds < 5400) return fmt::format("{:.0f} min", seconds / 60);
  return seconds < 172800 ? fmt::format("{:.1f} h", seconds / 3600) : fmt::format("{:.1f} days", seconds / 86400);
}

}  // namespace

TileWatch::TileWatch() : start_(std::chrono::steady_clock::now()), cpu_seconds_(cpu_seconds()) {}

TileRecord TileWatch::record() const {
  TileRecord record;
  record.seconds = seconds_since(start_);
  record.cpu_seconds = cpu_seconds() - cpu_seconds_;
  record.peak_bytes = peak_.bytes();
  record.threads = thread_count();
  record.host = host_name();
  record.ended = fmt::format("{:%Y-%m-%dT%H:%M:%SZ}", fmt::gmtime(std::time(nullptr)));
  return record;
}

void write_record(const Job& job, std::size_t k, const TileRecord& record) {
  const Json json{{"schema", schema},
                  {"job", job.id},
                  {"seconds", record.seconds},
                  {"cpu_seconds", record.cpu_seconds},
                  {"peak_bytes", record.peak_bytes ? Json(*record.peak_bytes) : Json()},
                  {"threads", record.threads},
                  {"host", record.host},
                  {"ended", record.ended}};
  write_text_atomically(job.tile_file(k, "json").string(),
                        json.dump(1, ' ', false, Json::error_handler_t::replace) + "\n");
}

std::optional<TileRecord> read_record(const Job& job, std::size_t k) {
  std::ifstream file(job.tile_file(k, "json"), std::ios::binary);
  const Json json = Json::parse(file, nullptr, false);
  try {
    if (json.at("schema") != schema || json.at("job") != job.id) return std::nullopt;
    TileRecord record;
    json.at("seconds").get_to(record.seconds), json.at("cpu_seconds").get_to(record.cpu_seconds);
    if (!json.at("peak_bytes").is_null()) record.peak_bytes = json.at("peak_bytes").get<std::uint64_t>();
    json.at("threads").get_to(record.threads);
    json.at("host").get_to(record.host), json.at("ended").get_to(record.ended);
    return record;
  } catch (const Json::exception&) {
    return std::nullopt;  // cut or changed: what a tile took is no part of the result
  }
}

TileProgress::TileProgress(const Job& job, const std::vector<std::size_t>& tiles, const Context& context)
    : job_(job), context_(context), start_(std::chrono::steady_clock::now()), tiles_(tiles.size()) {
  for (const std::size_t k : tiles) points_ += job.tiles[k].square.all();
}

void TileProgress::begin(std::size_t k) {
  std::string stage = fmt::format("tile {}, {} of {}", k, ++begun_, tiles_);
  const std::string pace = pace_in_words(points_done_, seconds_since(start_), points_ - points_done_);
  if (!pace.empty()) stage += ", " + pace;
  context_.step(stage, points_ == 0 ? 0 : static_cast<double>(points_done_) / static_cast<double>(points_));
}

void TileProgress::end(std::size_t k) { points_done_ += job_.tiles[k].square.all(); }

std::string pace_in_words(std::uint64_t points_done, double seconds, std::uint64_t points_left) {
  if (points_done == 0 || !(seconds > 0)) return "";
  const double rate = static_cast<double>(points_done) / seconds;
  std::string left;  // first: a narrow terminal cuts the end
  if (points_left > 0) left = duration_in_words(static_cast<double>(points_left) / rate) + " left, ";
  return left + fmt::format("{:.0f} points/s", rate);
}

}  // namespace isopach::cli
