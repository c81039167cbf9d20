// All fuzz targets as one program without libFuzzer, for every compiler: a test that runs the seeds of each target, and
// every input that ever failed through all of them; and, where clang is not at hand, mutations of them at random.
//
//   isopach-fuzz-replay SEEDS FOUND                                   the test: SEEDS/TARGET/*, FOUND/*/*
//   isopach-fuzz-replay SEEDS FOUND --mutate SECONDS [--only TARGET] [--from N]   mutations, the N-th run of them
//
// A seed whose name begins with "valid" must run to its end without an Error, and each target has one: otherwise a
// corpus that no target understands would pass. An input that fails under --mutate is left in the working folder.
#include <fcntl.h>
#include <sys/time.h>
#include <unistd.h>

#include <algorithm>
#include <chrono>
#include <csignal>
#include <ctime>
#include <exception>
#include <filesystem>
#include <fstream>
#include <iterator>
#include <string_view>
#include <vector>

#include "isopach/base/random.hpp"
#include "tests/fuzz/input.hpp"

#define TARGET(name) extern "C" int fuzz_##name(const std::uint8_t* data, std::size_t size);
#include "fuzz_targets.inc"
#undef TARGET

namespace {

namespace fs = std::filesystem;
using Bytes = std::vector<std::uint8_t>;
using Clock = std::chrono::steady_clock;

struct Target {
  const char* name;
  int (*run)(const std::uint8_t*, std::size_t);
};
constexpr Target targets[] = {
#define TARGET(name) {#name, fuzz_##name},
#include "fuzz_targets.inc"
#undef TARGET
};

constexpr time_t longest_run = 20;  // seconds of the processor: what else the machine does is no matter

struct Named {
  std::string name;
  Bytes bytes;
};

/// What runs now, for the handler of signals. `keep`: the input is in no file yet.
struct Running {
  const char* target = "";
  std::string name;
  Bytes bytes;
  bool keep = false;
} running;

void write_all(int file, const void* data, std::size_t size) { (void)!::write(file, data, size); }

void keep_input() noexcept {
  if (!running.keep) return;
  const int file = ::open(running.name.c_str(), O_WRONLY | O_CREAT | O_TRUNC, 0644);
  if (file < 0) return;
  write_all(file, running.bytes.data(), running.bytes.size());
  ::close(file);
}

void say_what_ran(int signal) {
  const std::string_view why = signal == SIGPROF ? " does not end: " : " ends the program: ";
  for (const std::string_view word :
       {std::string_view(running.target), why, std::string_view(running.name), std::string_view("\n")})
    write_all(STDERR_FILENO, word.data(), word.size());
  keep_input();
  ::_exit(1);
}

/// So many seconds of the processor from now; 0: not at all.
void stop_after(time_t seconds) {
  const itimerval timer{{0, 0}, {seconds, 0}};
  (void)::setitimer(ITIMER_PROF, &timer, nullptr);
}

/// False, and a line, for an exception that is no isopach::Error.
bool run(const Target& target, const Named& input, bool keep, double& seconds) {
  running = {target.name, input.name, input.bytes, keep};
  const std::clock_t start = std::clock();
  stop_after(longest_run);
  bool good = true;
  try {
    (void)target.run(input.bytes.data(), input.bytes.size());
  } catch (const std::exception& error) {
    std::fprintf(stderr, "%s: %s leaves with '%s'\n", target.name, input.name.c_str(), error.what());
    keep_input();
    good = false;
  }
  stop_after(0);
  seconds = static_cast<double>(std::clock() - start) / CLOCKS_PER_SEC;
  return good;
}

/// The files of a folder and of those in it, by name.
std::vector<Named> files_in(const fs::path& folder) {
  std::vector<fs::path> paths;
  std::error_code none;
  for (const auto& entry : fs::recursive_directory_iterator(folder, none))
    if (entry.is_regular_file() && entry.path().filename().string().front() != '.') paths.push_back(entry.path());
  std::sort(paths.begin(), paths.end());
  std::vector<Named> files;
  for (const fs::path& path : paths) {
    std::ifstream file(path, std::ios::binary);
    files.push_back({path.string(), Bytes(std::istreambuf_iterator<char>(file), {})});
  }
  return files;
}

bool is_valid_seed(const std::string& path) { return fs::path(path).filename().string().starts_with("valid"); }

/// The number of failures.
int replay(const Target& target, const std::vector<Named>& seeds, const std::vector<Named>& found) {
  int failures = 0;
  std::size_t valid = 0;
  double slowest = 0, seconds = 0;
  std::vector<Named> all = seeds;
  all.insert(all.end(), found.begin(), found.end());
  for (const Named& input : all) {
    const std::size_t before = isopach::fuzz::completed;
    if (!run(target, input, false, seconds)) ++failures;
    slowest = std::max(slowest, seconds);
    if (!is_valid_seed(input.name) || &input >= all.data() + seeds.size()) continue;
    ++valid;
    if (isopach::fuzz::completed > before) continue;
    std::fprintf(stderr, "%s: %s is refused: %s\n", target.name, input.name.c_str(), isopach::fuzz::refusal.c_str());
    ++failures;
  }
  if (valid == 0) std::fprintf(stderr, "%s: has no seed that is valid\n", target.name), ++failures;
  std::printf("%-10s %3zu inputs, the slowest %.3f s\n", target.name, all.size(), slowest);
  return failures;
}

/// Changes of bytes, after the usual ones of fuzzers; numbers that count something become one more or one less.
class Mutator {
 public:
  Mutator(const std::vector<Named>& seeds, std::uint64_t seed) : seeds_(seeds), random_(seed, 7) {}

  Bytes next() {
    Bytes bytes = seeds_.empty() || pick(4) == 0 ? noise() : seeds_[pick(seeds_.size())].bytes;
    for (std::size_t n = 1 + pick(6); n > 0; --n) change(bytes);
    return bytes;
  }

 private:
  std::size_t pick(std::size_t below) { return static_cast<std::size_t>(random_.bits(counter_++) % below); }
  std::uint8_t byte() { return static_cast<std::uint8_t>(pick(256)); }
  Bytes noise() {
    Bytes bytes(pick(400));
    for (std::uint8_t& b : bytes) b = byte();
    return bytes;
  }

  void change(Bytes& bytes) {
    if (bytes.empty()) bytes.push_back(byte());
    const std::size_t at = pick(bytes.size()), most = std::min<std::size_t>(bytes.size() - at, 1 + pick(32));
    const auto place = bytes.begin() + static_cast<std::ptrdiff_t>(at);
    switch (pick(8)) {
      case 0:
        *place = byte();
        break;
      case 1:
        *place = static_cast<std::uint8_t>(*place ^ 1u << pick(8));
        break;
      case 2:
        bytes.erase(place, place + static_cast<std::ptrdiff_t>(most));
        break;
      case 3: {
        const Bytes part(place, place + static_cast<std::ptrdiff_t>(most));
        bytes.insert(bytes.begin() + static_cast<std::ptrdiff_t>(pick(bytes.size())), part.begin(), part.end());
        break;
      }
      case 4:
        bytes.insert(place, byte());
        break;
      case 5:
        splice(bytes, at);
        break;
      case 6:
        miscount_binary(bytes, at);
        break;
      default:
        miscount_text(bytes, at);
    }
  }

  void splice(Bytes& bytes, std::size_t at) {
    if (seeds_.empty()) return;
    const Bytes& other = seeds_[pick(seeds_.size())].bytes;
    if (other.empty()) return;
    bytes.resize(at);
    bytes.insert(bytes.end(), other.begin() + static_cast<std::ptrdiff_t>(pick(other.size())), other.end());
  }

  /// A little-endian number of 2, 4 or 8 bytes.
  void miscount_binary(Bytes& bytes, std::size_t at) {
    const std::size_t width = std::size_t{2} << pick(3);
    const bool more = pick(2) == 0;
    for (std::size_t i = at; i < std::min(at + width, bytes.size()); ++i) {
      bytes[i] = static_cast<std::uint8_t>(more ? bytes[i] + 1 : bytes[i] - 1);
      if (bytes[i] != (more ? 0 : 255)) break;
    }
  }

  /// The last digit of the first number from there on.
  void miscount_text(Bytes& bytes, std::size_t at) {
    const auto is_digit = [](std::uint8_t c) { return '0' <= c && c <= '9'; };
    auto digit = std::find_if(bytes.begin() + static_cast<std::ptrdiff_t>(at), bytes.end(), is_digit);
    if (digit == bytes.end()) return;
    while (digit + 1 != bytes.end() && is_digit(digit[1])) ++digit;
    if (*digit != (pick(2) == 0 ? '9' : '0'))
      *digit = static_cast<std::uint8_t>(*digit == '9' ? '8' : *digit == '0' ? '1' : *digit + (pick(2) == 0 ? 1 : -1));
  }

  const std::vector<Named>& seeds_;
  isopach::RandomStream random_;
  std::uint64_t counter_ = 0;
};

int mutate(const Target& target, const std::vector<Named>& seeds, double seconds, std::uint64_t from) {
  Mutator mutator(seeds, from);
  const auto start = Clock::now();
  const auto elapsed = [&] { return std::chrono::duration<double>(Clock::now() - start).count(); };
  const std::size_t before = isopach::fuzz::completed;
  int failures = 0;
  std::size_t runs = 0;
  double slowest = 0, took = 0;
  for (; elapsed() < seconds && failures < 10; ++runs) {
    const Named input{"failed-" + std::string(target.name) + "-" + std::to_string(from) + "-" + std::to_string(runs),
                      mutator.next()};
    if (!run(target, input, true, took)) ++failures;
    if (took > 1 && took > slowest) {
      running.name = "slow" + input.name.substr(6);
      keep_input();
    }
    slowest = std::max(slowest, took);
  }
  std::printf("%-10s %zu mutations, %zu done without an error, the slowest %.3f s\n", target.name, runs,
              isopach::fuzz::completed - before, slowest);
  return failures;
}

struct Request {
  std::vector<std::string> folders;
  std::string only;
  double seconds = 0;
  std::uint64_t from = 1;
};

Request parse(int argc, char** argv) {
  Request request;
  for (int i = 1; i < argc; ++i) {
    const std::string word = argv[i];
    const std::string value = i + 1 < argc ? argv[i + 1] : "";
    if (word == "--mutate")
      request.seconds = std::stod(value), ++i;
    else if (word == "--only")
      request.only = value, ++i;
    else if (word == "--from")
      request.from = std::stoull(value), ++i;
    else
      request.folders.push_back(word);
  }
  return request;
}

}  // namespace

int main(int argc, char** argv) {
  const Request request = parse(argc, argv);
  if (request.folders.size() != 2) {
    std::fprintf(stderr, "usage: isopach-fuzz-replay SEEDS FOUND [--mutate SECONDS] [--only TARGET] [--from N]\n");
    return 2;
  }
  for (const int signal : {SIGSEGV, SIGABRT, SIGFPE, SIGBUS, SIGPROF}) std::signal(signal, say_what_ran);
  std::setvbuf(stdout, nullptr, _IOLBF, 0);
  const std::vector<Named> found = files_in(request.folders[1]);
  int failures = 0;
  for (const Target& target : targets) {
    if (!request.only.empty() && request.only != target.name) continue;
    const std::vector<Named> seeds = files_in(fs::path(request.folders[0]) / target.name);
    failures +=
        request.seconds > 0 ? mutate(target, seeds, request.seconds, request.from) : replay(target, seeds, found);
  }
  return failures == 0 ? 0 : 1;
}
