// kernel_bench: every experiment on the kernel, the rivals in the same run. Prints tables; writes benchmark.md and its
// plots. kernel_bench [--quick | --short] [--n POINTS] [--docs FOLDER] [--only EXPERIMENT]
#include <fmt/format.h>
#include <unistd.h>

#include <cstdlib>
#include <cstring>
#include <functional>
#include <stdexcept>
#include <utility>

#include "bench/experiments/experiments.hpp"
#include "bench/rivals/rival.hpp"
#include "bench/support/machine.hpp"
#include "bench/support/timer.hpp"
#include "isopach/io/write.hpp"

namespace {

using isopach::bench::Page;
using isopach::bench::Setup;

struct Arguments {
  Setup setup;
  std::string only, probe, docs;
};

Arguments parse(int argc, char** argv) {
  Arguments given;
  for (int i = 1; i < argc; ++i) {
    const std::string word = argv[i];
    const auto value = [&]() -> std::string {
      if (i + 1 >= argc) throw std::runtime_error(word + ": a value is missing");
      return argv[++i];
    };
    Setup& setup = given.setup;
    if (word == "--quick")
      setup.quick = true, setup.four_million = false, setup.n = 100'000, setup.repeats = 3, setup.slow_repeats = 1;
    else if (word == "--short")
      setup.four_million = false, setup.repeats = 3, setup.slow_repeats = 1;
    else if (word == "--n")
      given.setup.n = std::stoull(value());
    else if (word == "--docs")
      given.docs = value();
    else if (word == "--only")
      given.only = value();
    else if (word == "--probe")
      given.probe = value();
    else
      throw std::runtime_error(word + ": unknown; use --quick, --short, --n POINTS, --docs FOLDER, --only EXPERIMENT");
  }
  return given;
}

std::filesystem::path data_folder() {
  const char* named = std::getenv("ISOPACH_SHARED");
  const std::filesystem::path root = named != nullptr && *named != 0 ? named : "../shared";
  return std::filesystem::exists(root / "data") ? root / "data" : root;
}

void complete(Arguments& given) {
  Setup& setup = given.setup;
  setup.self = std::filesystem::read_symlink("/proc/self/exe");
  setup.programs = setup.self.parent_path();
  setup.shared = data_folder();
  // Only a whole run at full size may change the project's page.
  const bool official = !setup.quick && given.only.empty();
  setup.docs = !given.docs.empty() ? given.docs : official ? "docs/evidence" : "out/bench";
  setup.scratch = std::filesystem::temp_directory_path() / fmt::format("isopach-bench-{}", getpid());
  setup.sizes = {10'000, 30'000, 100'000};
  if (!setup.quick) setup.sizes.insert(setup.sizes.end(), {300'000, 1'000'000});
  if (setup.four_million) setup.sizes.insert(setup.sizes.end(), {2'000'000, 4'000'000});
  setup.worst_sizes = setup.quick ? std::vector<std::size_t>{250, 500, 1000, 2000}
                                  : std::vector<std::size_t>{250, 500, 1000, 2000, 4000, 8000, 16000};
}

void introduction(const Setup& setup, Page& page) {
  page.paragraph(
      "# Benchmark\n\nWritten by `make bench`; do not edit. Machine: " + isopach::bench::machine_description() +
      ". Rival: " + isopach::bench::rival::name() + ", exact predicates, inexact constructions, range insertion.");
  page.paragraph(
      "One thread is timed by its own CPU clock, two threads by the wall clock. Contestants take turns in one process "
      "and medians are compared, so ratios hold where absolute times do not. Freed memory stays in the process (no "
      "page faults on the clock), for everybody, except where whole processes are run. \"Not reached\" stands where a "
      "target is missed.");
  if (!setup.four_million)
    page.paragraph("A short run: fewer repeats, each whole program once, nothing with 4 000 000 points.");
  if (isopach::bench::machine_load() > 1)
    page.paragraph(
        "**Other work was going on**: wall times, and with them all numbers for two threads, are too large.");
}

using Experiment = void (*)(const Setup&, Page&);
constexpr std::pair<const char*, Experiment> experiments[] = {
    {"processes", isopach::bench::processes},   {"memory", isopach::bench::memory},
    {"contention", isopach::bench::contention}, {"delaunay", isopach::bench::delaunay},
    {"cliffs", isopach::bench::cliffs},         {"stages", isopach::bench::stages},
    {"whole", isopach::bench::whole},           {"growth", isopach::bench::growth},
    {"worst_case", isopach::bench::worst_case}, {"scipy", isopach::bench::scipy}};

void write_page(const Setup& setup, const Page& page) {
  std::filesystem::create_directories(setup.docs);
  isopach::write_atomically((setup.docs / "benchmark.md").string(), [&](const std::string& temporary) {
    std::FILE* file = std::fopen(temporary.c_str(), "wb");
    const std::string text = page.text().substr(1);
    if (file == nullptr || std::fwrite(text.data(), 1, text.size(), file) != text.size() || std::fclose(file) != 0)
      throw std::runtime_error("benchmark.md: cannot be written");
  });
}

}  // namespace

int main(int argc, char** argv) try {
  Arguments given = parse(argc, argv);
  if (!given.probe.empty()) return isopach::bench::memory_probe(given.probe, given.setup.n);
  complete(given);
  isopach::bench::keep_heap();
  std::filesystem::create_directories(given.setup.scratch);
  Page page;
  introduction(given.setup, page);
  bool any = false;
  for (const auto& [name, experiment] : experiments) {
    if (!given.only.empty() && given.only != name) continue;
    const double start = isopach::bench::wall_seconds();
    experiment(given.setup, page);
    fmt::print(stderr, "{}: {:.1f} s\n", name, isopach::bench::wall_seconds() - start);
    any = true;
  }
  std::filesystem::remove_all(given.setup.scratch);
  if (!any) throw std::runtime_error("--only " + given.only + ": no such experiment");
  write_page(given.setup, page);
  return 0;
} catch (const std::exception& error) {
  fmt::print(stderr, "kernel_bench: {}\n", error.what());
  return 1;
}
