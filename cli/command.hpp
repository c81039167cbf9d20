// What all verbs share: the look of their help, the options of every run, --config files, and one-line usage errors.
#pragma once
#include <cstdint>
#include <functional>
#include <limits>
#include <memory>
#include <optional>
#include <string>
#include <string_view>
#include <utility>
#include <vector>

#include "cli/progress.hpp"
#include "cli/verbs.hpp"
#include "isopach/base/context.hpp"
#include "isopach/base/watch.hpp"

namespace CLI {
class App;
class Option;
}  // namespace CLI

namespace isopach::cli {

/// " (did you mean 'x'?)" for the nearest name, or nothing if none is near.
[[nodiscard]] std::string did_you_mean(const std::string& word, const std::vector<std::string>& names);

/// 2500, 40k, 1.5G: bytes; k, M, G, T are powers of 1000. UsageError, naming the option, for anything else.
[[nodiscard]] std::uint64_t parse_size(const std::string& text, const char* option);

/// A check of an option's text: what is wrong with it in one line, or nothing.
using Check = std::function<std::string(const std::string& text)>;

[[nodiscard]] Check whole_number(std::uint64_t least, std::uint64_t most = std::numeric_limits<std::uint64_t>::max());
[[nodiscard]] Check share();  ///< a number from 0 to 1
[[nodiscard]] Check not_negative();
[[nodiscard]] Check positive();
[[nodiscard]] Check not_empty();

/// An option of a Command, which it belongs to.
class Option {
 public:
  Option() = default;
  explicit Option(CLI::Option* option) : option_(option) {}

  Option check(const Check& check) const;
  Option required(bool is) const;
  /// Called with each text that is given, in the order in which options were declared.
  Option each(const std::function<void(const std::string& text)>& heard) const;
  /// The help shows the value that its target has now as the default.
  Option show_default() const;
  /// After Command::parse.
  [[nodiscard]] bool is_given() const;

 private:
  CLI::Option* option_ = nullptr;
};

/// A verb's parser. Options declared here appear in its --help and may stand in its --config file. CLI11 is seen by
/// command.cpp alone, where options are compiled for the types of values named there: it takes the compiler four
/// seconds.
class Command {
 public:
  Command(const std::string& verb, const std::string& description, const std::string& footer);
  ~Command();
  Command(const Command&) = delete;
  Command& operator=(const Command&) = delete;

  /// Options that follow are listed under this heading.
  void heading(const std::string& text) { heading_ = text; }

  template <class T>
  Option positional(const std::string& name, T& target, const std::string& description);
  template <class T>
  Option option(const std::string& names, const std::string& type, T& target, const std::string& description);
  Option flag(const std::string& names, bool& target, const std::string& description);
  /// An option with a few named values; shows them all and the one in `target` as the default.
  template <class E>
  Option choice(const std::string& names, E& target, const std::vector<std::pair<std::string, E>>& values,
                const std::string& description);
  /// An option whose text `read` turns into a value; what it throws (UsageError, InputError) ends the run.
  template <class T>
  Option parsed(const std::string& names, const std::string& type, T& target, T (*read)(const std::string& text),
                const std::string& description) {
    return option_with(
        names, type, [&target, read](const std::string& text) { target = read(text); }, description);
  }

  /// The same for an option that sets more than one value.
  Option option_with(const std::string& names, const std::string& type,
                     const std::function<void(const std::string& text)>& read, const std::string& description,
                     const std::string& default_value = "");

  /// False if --help or --version was asked for and printed. Throws UsageError with one line.
  [[nodiscard]] bool parse(const Arguments& arguments);

  /// After parse: the options that were given, on the command line or by --config, as words that give them again; not
  /// those of these long names, and no positional ones.
  [[nodiscard]] Arguments given_options(const std::vector<std::string>& but) const;

 private:
  [[nodiscard]] std::string unknown_word() const;

  std::unique_ptr<CLI::App> app_;
  std::string verb_, heading_ = "Options";
};

template <class E>
Option Command::choice(const std::string& names, E& target, const std::vector<std::pair<std::string, E>>& values,
                       const std::string& description) {
  std::string type, chosen;
  for (const auto& [name, value] : values) {
    type += (type.empty() ? "" : "|") + name;
    if (value == target) chosen = name;
  }
  return option_with(
      names, type,
      [&target, values, type, names](const std::string& text) {
        for (const auto& [name, value] : values)
          if (name == text) {
            target = value;
            return;
          }
        throw UsageError(names + ": '" + text + "' is not one of " + type);
      },
      description, chosen);
}

/// The options every run has.
struct RunOptions {
  int threads = 0;
  bool quiet = false, verbose = false;
  ProgressKind progress = ProgressKind::automatic;
};

void add_run_options(Command& command, RunOptions& options);
void add_seed(Command& command, std::uint64_t& seed);

/// The context of a run with its progress display; interrupts are wired to it.
class Run {
 public:
  explicit Run(const RunOptions& options, std::uint64_t seed = 1);

  [[nodiscard]] const Context& context() const { return context_; }
  /// A message on stderr, unless --quiet.
  void say(const std::string& line);
  /// A warning of the library on stderr, with its options spelled, unless --quiet.
  void warn(const std::string& warning);
  /// A result on stdout, unless --quiet.
  void show(const std::string& text);
  /// A result that was asked for by name (--json -): on stdout, --quiet or not.
  void print(const std::string& text);

 private:
  bool quiet_;
  Progress progress_;
  Context context_;
  std::optional<Watch> watch_;  ///< of the flag of context_
};

}  // namespace isopach::cli
