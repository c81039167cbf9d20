// isopach sequence FRAME...
#include "isopach/apps/sequence.hpp"

#include <fmt/core.h>

#include <algorithm>
#include <filesystem>
#include <memory>

#include "cli/answer.hpp"
#include "cli/command.hpp"
#include "cli/output.hpp"
#include "cli/parse.hpp"
#include "cli/session.hpp"
#include "cli/verbs.hpp"
#include "isopach/io/read.hpp"
#include "isopach/report/sequence.hpp"

namespace isopach::cli {
namespace {

constexpr const char* description =
    "What of a sequence of scans stays and what moves, e.g. a chewing face: the two parts, found from the sequence "
    "itself,\n"
    "and the motion of the one relative to the other in every frame: opening, path of a point, hinge axis.\n";

constexpr const char* footer =
    "Frames are read one at a time; one that cannot be used is reported and skipped.\n"
    "Exit codes: 0 done, 2 wrong usage, 3 the reference cannot be read, or nothing moves, 5 the frames are\n"
    "not of the object that the reference shows, 130 interrupted.\n"
    "\n"
    "Examples:\n"
    "  isopach sequence scans/ -o result                    every scan of a folder, in the order of their numbers\n"
    "  isopach sequence f01.ply f02.ply f03.ply --rate 15   frames by name, 15 a second\n"
    "  isopach simulate chewing -o scans                    a sequence with known truth to try it on";

struct Request {
  std::vector<std::string> frames;
  Delivery delivery;
  SequenceOptions options;
  RunOptions run;
};

bool is_digit(char c) { return '0' <= c && c <= '9'; }

/// Numbers in names count as numbers: f2 before f10.
bool name_less(const std::string& a, const std::string& b) {
  std::size_t i = 0, j = 0;
  while (i < a.size() && j < b.size()) {
    if (is_digit(a[i]) && is_digit(b[j])) {
      std::size_t i2 = i, j2 = j;
      while (i2 < a.size() && is_digit(a[i2])) ++i2;
      while (j2 < b.size() && is_digit(b[j2])) ++j2;
      while (i < i2 && a[i] == '0') ++i;
      while (j < j2 && b[j] == '0') ++j;
      if (i2 - i != j2 - j) return i2 - i < j2 - j;
      const int order = a.compare(i, i2 - i, b, j, j2 - j);
      if (order != 0) return order < 0;
      i = i2, j = j2;
    } else {
      if (a[i] != b[j]) return a[i] < b[j];
      ++i, ++j;
    }
  }
  if (i < a.size() || j < b.size()) return j < b.size();
  return a < b;
}

std::vector<std::string> scans_in(const std::string& folder) {
  static const std::vector<std::string> known{".ply", ".xyz", ".txt", ".csv", ".pts", ".ptx",
                                              ".las", ".laz", ".obj", ".stl", ".pcd"};
  std::vector<std::string> found;
  std::error_code failure;
  for (const auto& entry : std::filesystem::directory_iterator(folder, failure)) {
    std::string extension = entry.path().extension().string();
    for (char& c : extension) c = static_cast<char>(std::tolower(static_cast<unsigned char>(c)));
    if (entry.is_regular_file() && std::find(known.begin(), known.end(), extension) != known.end())
      found.push_back(entry.path().string());
  }
  if (failure) throw InputError(folder + ": the folder cannot be read: " + failure.message());
  if (found.empty()) throw InputError(folder + ": no scans in this folder: it holds none of .ply, .xyz, .las, …");
  std::sort(found.begin(), found.end(), name_less);
  return found;
}

std::vector<std::string> all_frames(const std::vector<std::string>& words) {
  std::vector<std::string> all;
  for (const std::string& word : words) {
    if (session().scans.contains(word) || !std::filesystem::is_directory(word)) {
      all.push_back(word);
      continue;
    }
    const std::vector<std::string> inside = scans_in(word);
    all.insert(all.end(), inside.begin(), inside.end());
  }
  return all;
}

std::optional<Point3> parse_point(const std::string& text, const char* option) {
  std::array<double, 3> value{};
  std::size_t begin = 0;
  for (std::size_t i = 0; i < 3; ++i) {
    const std::size_t end = i < 2 ? text.find(',', begin) : text.size();
    if (end == std::string::npos || (i == 2 && text.find(',', begin) != std::string::npos))
      throw UsageError(fmt::format("{}: '{}' is not a place X,Y,Z", option, text));
    value[i] = parse_number(text.substr(begin, end - begin), option);
    begin = end + 1;
  }
  return Point3{value[0], value[1], value[2]};
}
std::optional<Point3> parse_static_at(const std::string& text) { return parse_point(text, "--static-at"); }
std::optional<Point3> parse_follow(const std::string& text) { return parse_point(text, "--follow"); }

void add_options(Command& command, Request& request) {
  SequenceOptions& o = request.options;
  command.heading("Sequence");
  command.option("--reference", "N", o.reference, "Frame that angles and ways are relative to, counted from 0")
      .check(whole_number(0, 1'000'000'000))
      .show_default();
  command.option("--rate", "HZ", o.rate, "Frames a second (default: unknown, times are frame numbers)")
      .check(positive());
  command.option("--smooth", "N", o.smooth, "Frames to either side that paths are smoothed over; 0: not")
      .check(not_negative())
      .show_default();
  command.parsed("--follow", "X,Y,Z", o.follow, parse_follow,
                 "Point of the moving part to follow, in coordinates of the reference (default: the one farthest from "
                 "the hinge axis)");
  command.parsed("--unit", "m|mm|cm|um|km|ft|us-ft|in", o.unit, parse_unit,
                 "Unit of the frames, where the files do not say it or say it wrongly");
  command.heading("Parts");
  command.parsed("--static-at", "X,Y,Z", o.static_at, parse_static_at,
                 "A place on the part that stays, in coordinates of the reference (default: the part that moves less)");
  command
      .option("--least-part", "SHARE", o.least_part,
              "Share of the reference's points that the smaller part has at least")
      .check(share())
      .show_default();
  command
      .option("--model-points", "N", o.model_points,
              "Points of the reference that parts are found and fitted by, about")
      .check(whole_number(500, max_nodes))
      .show_default();
}

void add_output_options(Command& command, Delivery& delivery) {
  add_result_options(
      command, delivery,
      "Folder for report.html, result.json, motion.csv and parts.ply (the reference with part and blend); made "
      "if it is not there");
}

}  // namespace

std::string SequenceAnswer::json(const std::vector<std::string>& outputs) const {
  return sequence_json(sequence, outputs);
}
std::string SequenceAnswer::text() const { return sequence_text(sequence); }
void SequenceAnswer::add_output_options(Command& command, Delivery& delivery) const {
  cli::add_output_options(command, delivery);
}

void SequenceAnswer::deliver(const Delivery& delivery, OutputFolder* folder, Run& run) {
  SequenceResult& r = sequence;
  Stopwatch watch;
  std::string json;
  if (folder != nullptr) {
    folder->write_text("motion.csv", sequence_csv(r));
    write_parts(folder->path("parts.ply"), r, run.context());
    const std::string page = folder->path("report.html"), result = folder->path("result.json");
    set_write_time(r.timing, watch.lap());
    json = sequence_json(r, folder->names());
    write_text_atomically(result, json);
    write_text_atomically(page, sequence_html(r, json, run.context()));
    run.context().check();
    folder->commit();
  } else if (!delivery.json.empty()) {
    json = sequence_json(r, {});
  }
  if (!delivery.json.empty()) write_json(delivery.json, json, run);
  if (delivery.json != "-") {
    run.show(sequence_text(r));
    if (folder != nullptr) run.show("report: " + folder->final_path("report.html"));
  } else {
    for (const std::string& warning : r.warnings) run.warn(warning);
  }
}

int run_sequence(const Arguments& arguments) {
  Request request;
  Command command("sequence", description, footer);
  command.positional("FRAME", request.frames,
                     "Scans in the order of time, or a folder of them; any format compare reads");
  add_options(command, request);
  add_output_options(command, request.delivery);
  add_run_options(command, request.run);
  if (!command.parse(arguments)) return 0;

  Run run(request.run);
  const std::vector<std::string> frames = all_frames(request.frames);
  std::unique_ptr<OutputFolder> folder;
  if (!request.delivery.output.empty()) folder = std::make_unique<OutputFolder>(request.delivery.output);
  ReadOptions wanted;
  wanted.attributes.clear();
  Context reading = run.context();
  reading.progress = nullptr;  // the stage on show is that of the sequence
  const FrameSource source{
      frames.size(), [&](std::size_t k) { return std::filesystem::path(name_of_scan(frames[k])).filename().string(); },
      [&](std::size_t k) { return cloud_named(frames[k], wanted, reading); }};
  auto answer = std::make_unique<SequenceAnswer>();
  answer->sequence = sequence(source, request.options, run.context());
  return finish(std::move(answer), request.delivery, folder.get(), run);
}

}  // namespace isopach::cli
