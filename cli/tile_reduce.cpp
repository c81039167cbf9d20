// The parts of a job as one comparison.
#include <fmt/format.h>

#include <algorithm>
#include <memory>
#include <utility>

#include "cli/command.hpp"
#include "cli/compare_request.hpp"
#include "cli/session.hpp"
#include "cli/tile_files.hpp"
#include "cli/tile_job.hpp"
#include "isopach/base/error.hpp"
#include "isopach/base/memory.hpp"
#include "isopach/base/parallel.hpp"
#include "isopach/compare/stages.hpp"
#include "isopach/tiles/join.hpp"
#include "isopach/tiles/part_bytes.hpp"

namespace isopach::cli {
namespace fs = std::filesystem;
namespace {

InputSummary summary_of(const JobScan& scan, const char* role, const Cleaning& of_nodes, std::size_t nodes) {
  InputSummary s = stages::summarise_file(scan.header(), role);
  s.points = scan.extent.cleaning.points, s.nodes = nodes;
  s.cleaning = scan.extent.cleaning;
  s.cleaning.duplicates = of_nodes.duplicates, s.cleaning.duplicate_max_spread = of_nodes.duplicate_max_spread;
  s.bounds = scan.extent.finite, s.nodata = scan.nodata;
  return s;
}

class Reducer {
 public:
  Reducer(const Job& job, const CompareOptions& options, Run& run)
      : job_(job), options_(options), run_(run), context_(run.context()) {}

  Comparison run(bool allow_missing, const LookAtCells& look, JoinedNodes* nodes) {
    if (!allow_missing) refuse_broken_files();
    const std::vector<std::size_t> done = tiles_done(allow_missing);
    Comparison c;
    c.options = options_;
    c.frame = job_.frame;
    stages::check_units(job_.scan[0].header(), job_.scan[1].header(), options_, c);
    TilesToJoin tiles;
    tiles.is_raster = {job_.is_raster(0, options_), job_.is_raster(1, options_)};
    std::size_t first_node = 0;
    for (const std::size_t k : done) {
      const fs::path of_cells = job_.tile_file(k, "cells");
      tiles.parts.push_back(read_part(job_, k));
      const auto open = [of_cells, id = job_.id, first_node] { return cells_in(of_cells, id, first_node); };
      const std::shared_ptr<const CellPart> first = open();
      if (first->xy.size() != tiles.parts.back().nodes) fail_to_fit(of_cells);
      tiles.cells.push_back({first->triangles.size(), open});
      first_node += tiles.parts.back().nodes;
      context_.step("reading parts", static_cast<double>(tiles.parts.size()) / static_cast<double>(done.size()));
    }
    require_memory(done);
    describe(tiles.parts, done, c);
    if (nodes != nullptr) nodes->tiles = done, tiles.heights = &nodes->heights;
    if (look) tiles.look = [&](const PartedCells& all) { look(all, c); };
    hint_at_matching(join_tiles(std::move(tiles), c, context_), c);
    warn_of_what_is_missing(done, c);
    return c;
  }

 private:
  [[nodiscard]] std::vector<std::size_t> tiles_done(bool allow_missing) const {
    std::vector<std::size_t> done;
    std::size_t missing = 0, first = 0;
    for (std::size_t k = 0; k < job_.tiles.size(); ++k) {
      if (job_.is_done(k))
        done.push_back(k);
      else if (missing++ == 0)
        first = k;
    }
    if (missing > 0 && !allow_missing)
      throw InputError(
          fmt::format("{}: {} of {} tiles are not done, the first is {}: run them (isopach tile run {} --missing), or "
                      "compare the points of the others alone (--allow-missing)",
                      job_.folder.string(), missing, job_.tiles.size(), first, job_.folder.string()));
    return done;
  }

  /// Before the nodes that were passed up are triangulated.
  void require_memory(const std::vector<std::size_t>& done) const {
    std::uintmax_t bytes = 0;
    for (const std::size_t k : done) bytes += fs::file_size(job_.tile_file(k, "part"));
    constexpr double of_program = 130e6, for_each_byte = 2.4;
    const auto needed = static_cast<std::uint64_t>(of_program + for_each_byte * static_cast<double>(bytes));
    if (needed > usable_memory())
      throw InputError(
          fmt::format("{}: joining its tiles takes about {}, and this machine has {}: reduce it on one with more "
                      "memory, or plan it "
                      "with larger tiles (--max-memory), which pass up less",
                      job_.folder.string(), bytes_in_words(needed), bytes_in_words(usable_memory())));
    if (job_.memory > 0 && needed > job_.memory)
      run_.warn(fmt::format("joining the tiles takes about {}, more than --max-memory {}", bytes_in_words(needed),
                            bytes_in_words(job_.memory)));
  }

  void refuse_broken_files() const {
    for (const JobScan& scan : job_.scan)
      if (!scan.broken.empty())
        throw InputError(fmt::format(
            "{}: {} of {} files of {} could not be read when it was planned (the first: {}): repair them and "
            "plan the job again, or compare the points of the others alone (--allow-missing)",
            job_.folder.string(), scan.broken.size(), scan.broken.size() + scan.files.size(), scan.name,
            scan.broken.front().why));
  }

  void warn_of_what_is_missing(const std::vector<std::size_t>& done, Comparison& c) const {
    if (done.size() < job_.tiles.size()) {
      std::uint64_t points = 0;
      for (const JobTile& tile : job_.tiles) points += tile.square.all();
      for (const std::size_t k : done) points -= job_.tiles[k].square.all();
      c.warnings.push_back(fmt::format("{} of {} tiles are missing: their {} points are no part of this comparison",
                                       job_.tiles.size() - done.size(), job_.tiles.size(), points));
    }
    for (const JobScan& scan : job_.scan) {
      if (scan.broken.empty()) continue;
      std::string names;
      for (const BrokenFile& file : scan.broken) names += (names.empty() ? "" : ", ") + file.path;
      c.warnings.push_back(
          fmt::format("{}: {} of {} files could not be read, and their points are no part of this comparison: {}",
                      scan.name, scan.broken.size(), scan.broken.size() + scan.files.size(), names));
    }
  }

  void describe(const std::vector<Part>& parts, const std::vector<std::size_t>& done, Comparison& c) {
    for (std::size_t k = 0; k < 2; ++k) {
      Cleaning of_nodes;
      std::size_t nodes = 0;
      LayerCheck layers;
      for (const Part& part : parts) {
        const ScanPart& s = part.scan[k];
        nodes += s.nodes;
        of_nodes.duplicates += s.cleaning.duplicates;
        of_nodes.duplicate_max_spread = std::max(of_nodes.duplicate_max_spread, s.cleaning.duplicate_max_spread);
        layers.add(s.layers);
      }
      InputSummary& s = k == 0 ? c.a : c.b;
      s = summary_of(job_.scan[k], k == 0 ? "A" : "B", of_nodes, nodes);
      if (options_.check_layers && nodes > 0) s.layered_share = layered_share(k, std::move(layers), done, s);
    }
    stages::warn_of_layers(c);
  }

  /// One more look at all points.
  double layered_share(std::size_t k, LayerCheck layers, const std::vector<std::size_t>& done, const InputSummary& s) {
    const PlacedFile file(job_.folder / "points");
    double share = 0;
    run_with_threads(context_, [&] {
      layers.begin(s.nodes + s.cleaning.duplicates, job_.frame.curve);
      for (const std::size_t tile : done)
        for (const PointRun& run : job_.tiles[tile].runs[k]) layers.add_points(read_runs(file, {run}));
      share = layers.share(context_);
    });
    return share;
  }

  const Job& job_;
  const CompareOptions& options_;
  Run& run_;
  const Context& context_;
};

}  // namespace

Comparison reduce_job(const Job& job, const CompareOptions& options, bool allow_missing, const LookAtCells& look,
                      Run& run, JoinedNodes* nodes) {
  try {
    return Reducer(job, options, run).run(allow_missing, look, nodes);
  } catch (const OverlapError&) {  // it speaks of the scans, which the words of this run may not name
    session().scan_words = {job.scan[0].name, job.scan[1].name};
    throw;
  }
}

}  // namespace isopach::cli
