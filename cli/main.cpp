// isopach <verb> ...: finds the verb, runs it, and turns every failure into one line on stderr and an exit code.
#include <fmt/core.h>
#include <unistd.h>

#include <cstdio>
#include <exception>
#include <new>

#include "cli/command.hpp"
#include "cli/input_words.hpp"
#include "cli/interrupt.hpp"
#include "cli/terminal.hpp"
#include "cli/verbs.hpp"
#include "isopach/base/error.hpp"
#include "isopach/base/option_key.hpp"
#include "isopach/io/output_file.hpp"
#include "isopach/version.hpp"

namespace isopach::cli {
namespace {

const std::vector<Verb>& verbs() {
  static const std::vector<Verb> all{
      {"compare", "how much and where scan B differs from scan A", run_compare},
      {"match", "the pose of one scan on another that minimises the measure between them", run_match},
      {"distance", "distances in space: nearest point or surface, normal, Hausdorff, M3C2", run_distance},
      {"asymmetry", "symmetry plane of a face, how and where its two sides differ", run_asymmetry},
      {"accuracy", "a reconstruction against a reference scan: bias, scatter, completeness, verdict", run_accuracy},
      {"scanners", "two scanners on one object: noise, bias, and which detail each resolves", run_scanners},
      {"roughness", "areal roughness and wrinkles, once form and waviness are removed", run_roughness},
      {"sequence", "static and moving part of a sequence of scans, and the motion of every frame", run_sequence},
      {"combine", "two scans in one model, by a reference object that is seen in both", run_combine},
      {"info", "what files hold: points, bounds, unit, CRS, attributes, layers", run_info},
      {"simulate", "two scans of a simulated scene whose true volumes are known", run_simulate},
      {"demo", "simulate, compare and report, with the truth beside the result", run_demo},
      {"convert", "between the supported formats", run_convert},
      {"tile", "compare scans larger than memory, or on many machines: the bits of compare", run_tile_verb},
  };
  return all;
}

std::string overview() {
  std::string text =
      "isopach compares two 3D scans of one surface without a grid.\n\nUsage: isopach <verb> [options] ...\n\nVerbs:\n";
  for (const Verb& verb : verbs()) text += fmt::format("  {:<10} {}\n", verb.name, verb.summary);
  return text +
         "\nisopach <verb> --help explains one verb; isopach --version prints the version.\n"
         "\nExamples:\n"
         "  isopach demo -o isopach-demo\n"
         "  isopach compare before.laz after.laz -o result\n"
         "  isopach info before.laz\n";
}

int run(const Arguments& words) {
  if (words.empty()) {
    std::fputs(overview().c_str(), stderr);
    return static_cast<int>(ExitCode::usage);
  }
  const std::string& word = words.front();
  if (word == "--help" || word == "-h" || word == "help") {
    std::fputs(overview().c_str(), stdout);
    return 0;
  }
  if (word == "--version") {
    fmt::print("isopach {}\n", version);
    return 0;
  }
  std::vector<std::string> names;
  for (const Verb& verb : verbs()) {
    if (verb.name == word) return verb.run({words.begin() + 1, words.end()});
    names.push_back(verb.name);
  }
  throw UsageError(fmt::format("unknown verb '{}'{}; isopach --help lists the verbs", word, did_you_mean(word, names)));
}

int fail(ExitCode code, const std::string& message) {
  std::string line = message;
  for (char& c : line)
    if (c == '\n' || c == '\r') c = ' ';
  std::fflush(stdout);
  write_message(fmt::format("isopach: {}\n", printable(place_of(line))));
  return static_cast<int>(code);
}

constexpr const char* no_memory = "out of memory: thin or crop the scans, or use a machine with more memory";

/// What nothing can catch, such as a thread that oneTBB cannot start, or memory that is not there where the standard
/// library must not throw: one line and the exit code of a failure inside. The unfinished folder is left to the next
/// run.
[[noreturn]] void end_without_stack() noexcept {
  std::string cause = "no memory or no thread to be had";
  try {
    if (const std::exception_ptr failure = std::current_exception()) std::rethrow_exception(failure);
  } catch (const std::bad_alloc&) {
    write_message("isopach: ended at once, ");
    write_message(no_memory);
    write_message("\n");
    _exit(static_cast<int>(ExitCode::internal));
  } catch (const std::exception& error) {
    cause = error.what();
  } catch (...) {
  }
  write_message(fmt::format("isopach: ended by a limit of this machine ({}): use fewer --threads, or raise the limit\n",
                            printable(cause)));
  _exit(static_cast<int>(ExitCode::internal));
}

/// Before any object of the program is made: those of static storage want memory too, and a failure there ends as every
/// other does.
[[gnu::constructor(101)]] void prepare_to_fail() {
  catch_interrupts();
  std::set_terminate(end_without_stack);
}

}  // namespace
}  // namespace isopach::cli

int main(int argc, char** argv) {
  using isopach::ExitCode;
  try {
    const int code = isopach::cli::run({argv + 1, argv + argc});
    if (std::fflush(stdout) != 0 || std::ferror(stdout) != 0) {
      if (isopach::cli::has_no_reader(STDOUT_FILENO)) isopach::cli::end_by_broken_pipe();
      return isopach::cli::fail(ExitCode::internal, "cannot write to standard output: is the disk full?");
    }
    return code;
  } catch (const isopach::Error& error) {
    const std::string text = isopach::for_shell(error.what());
    const bool of_files = error.code() == ExitCode::input || error.code() == ExitCode::no_overlap;
    return isopach::cli::fail(error.code(), of_files ? isopach::cli::naming_a_scan(text) : text);
  } catch (const std::bad_alloc&) {
    return isopach::cli::fail(ExitCode::internal, isopach::cli::no_memory);
  } catch (const std::exception& error) {
    return isopach::cli::fail(ExitCode::internal, fmt::format("internal failure: {}", error.what()));
  }
}
