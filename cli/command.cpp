#include "cli/command.hpp"

#include <fmt/core.h>

#include <CLI/CLI.hpp>

#include <algorithm>
#include <charconv>
#include <cmath>
#include <cstdio>
#include <functional>
#include <limits>
#include <numeric>
#include <optional>
#include <sstream>

#include "cli/interrupt.hpp"
#include "cli/session.hpp"
#include "cli/terminal.hpp"
#include "isopach/base/error.hpp"
#include "isopach/base/option_key.hpp"
#include "isopach/base/thread_limit.hpp"
#include "isopach/io/input_file.hpp"
#include "isopach/version.hpp"

namespace isopach::cli {
namespace {

constexpr std::size_t page_width = 110, name_width = 34;

std::string trimmed(const std::string& text, const char* drop = " \t\r") {
  const std::size_t first = text.find_first_not_of(drop);
  if (first == std::string::npos) return "";
  return text.substr(first, text.find_last_not_of(drop) - first + 1);
}

/// Help in two columns: names and type on the left, the description wrapped on the right with its default at the end.
class HelpFormatter : public CLI::Formatter {
 public:
  std::string make_option(const CLI::Option* option, bool is_positional) const override {
    std::string left = "  " + make_option_name(option, is_positional);
    std::replace(left.begin(), left.end(), ',', ' ');
    if (!is_positional && option->get_type_size() != 0) left += " " + option->get_type_name();
    std::string text = option->get_description();
    if (!option->get_default_str().empty()) text += fmt::format(" (default {})", option->get_default_str());

    std::string out = left;
    if (left.size() + 1 > name_width)
      out += "\n" + std::string(name_width, ' ');
    else
      out += std::string(name_width - left.size(), ' ');
    std::size_t column = name_width;
    std::istringstream words(text);
    for (std::string word; words >> word;) {
      if (column > name_width && column + 1 + word.size() > page_width) {
        out += "\n" + std::string(name_width, ' ');
        column = name_width;
      }
      if (column > name_width) out += ' ', ++column;
      out += word;
      column += word.size();
    }
    return out + "\n";
  }
  std::string make_group(std::string group, bool is_positional,
                         std::vector<const CLI::Option*> options) const override {
    std::string out = (is_positional ? "\n" : "") + group + ":\n";
    for (const CLI::Option* option : options) out += make_option(option, is_positional);
    return is_positional ? out + "\n" : out;
  }
};

/// The file of --config: lines `name = value` with the names of the options; # begins a comment, values may stand in
/// quotes, a list may stand in brackets, a name alone switches a flag on.
class ConfigFile : public CLI::Config {
 public:
  explicit ConfigFile(const CLI::App& app) : app_(app) {}

  std::string to_config(const CLI::App*, bool, bool, std::string) const override { return {}; }

  std::vector<CLI::ConfigItem> from_config(std::istream& input) const override {
    std::vector<CLI::ConfigItem> found;
    std::string line;
    for (int number = 1; std::getline(input, line); ++number) {
      line = trimmed(without_comment(line));
      if (line.empty()) continue;
      const std::size_t equals = line.find('=');
      CLI::ConfigItem item;
      item.name = trimmed(line.substr(0, equals));
      std::string value = equals == std::string::npos ? "true" : trimmed(line.substr(equals + 1));
      if (value.size() > 1 && value.front() == '[' && value.back() == ']') value = joined(value);
      item.inputs = {trimmed(value, "\"'")};
      if (app_.get_option_no_throw("--" + item.name) == nullptr)
        throw UsageError(fmt::format("{}:{}: unknown option '{}'{}", app_.get_config_ptr()->as<std::string>(), number,
                                     item.name, did_you_mean(item.name, names())));
      found.push_back(std::move(item));
    }
    return found;
  }

 private:
  static std::string without_comment(const std::string& line) {
    char quote = 0;
    for (std::size_t i = 0; i < line.size(); ++i) {
      const char c = line[i];
      if (quote != 0)
        quote = c == quote ? 0 : quote;
      else if (c == '"' || c == '\'')
        quote = c;
      else if (c == '#')
        return line.substr(0, i);
    }
    return line;
  }
  static std::string joined(const std::string& list) {
    std::istringstream words(list.substr(1, list.size() - 2));
    std::string out;
    for (std::string word; std::getline(words, word, ',');)
      out += (out.empty() ? "" : ",") + trimmed(trimmed(word), "\"'");
    return out;
  }
  std::vector<std::string> names() const {
    std::vector<std::string> all;
    for (const CLI::Option* option : app_.get_options())
      for (const std::string& name : option->get_lnames()) all.push_back(name);
    return all;
  }

  const CLI::App& app_;
};

std::size_t edit_distance(const std::string& a, const std::string& b) {
  std::vector<std::size_t> row(b.size() + 1);
  std::iota(row.begin(), row.end(), std::size_t{0});
  for (std::size_t i = 1; i <= a.size(); ++i) {
    std::size_t diagonal = row[0];
    row[0] = i;
    for (std::size_t j = 1; j <= b.size(); ++j) {
      const std::size_t change = diagonal + (a[i - 1] == b[j - 1] ? 0 : 1);
      diagonal = row[j];
      row[j] = std::min({change, row[j] + 1, row[j - 1] + 1});
    }
  }
  return row[b.size()];
}

}  // namespace

std::string did_you_mean(const std::string& word, const std::vector<std::string>& names) {
  std::string best;
  std::size_t least = std::max<std::size_t>(1, word.size() / 3) + 1;
  for (const std::string& name : names) {
    const std::size_t distance = edit_distance(word, name);
    if (distance < least) least = distance, best = name;
  }
  return best.empty() ? "" : fmt::format(" (did you mean '{}'?)", best);
}

namespace {

/// CLI11's message in the words of this program.
std::string plain_words(const CLI::ParseError& error, const std::string& config) {
  const std::string text = error.what();
  const std::size_t colon = text.find(": "), required = text.find(" required ");
  const std::string option = text.substr(0, colon), missing = " missing";
  if (error.get_name() == "FileError") return fmt::format("--config {}: cannot be read: check the path", config);
  if (error.get_name() != "ArgumentMismatch" || colon == std::string::npos || required == std::string::npos)
    return text;
  if (text.find(": At Most 1 ") == colon) return option + ": given more than once";
  if (text.size() > missing.size() && text.compare(text.size() - missing.size(), missing.size(), missing) == 0) {
    const std::size_t type = required + std::string(" required ").size();
    return fmt::format("{}: its value is missing: {}", option, text.substr(type, text.size() - missing.size() - type));
  }
  return text;
}

template <class T>
bool read_all(const std::string& text, T& value) {
  const auto [end, error] = std::from_chars(text.data(), text.data() + text.size(), value);
  return error == std::errc{} && end == text.data() + text.size();
}

}  // namespace

Check whole_number(std::uint64_t least, std::uint64_t most) {
  return [=](const std::string& text) {
    std::uint64_t value = 0;
    if (read_all(text, value) && least <= value && value <= most) return std::string();
    if (most == std::numeric_limits<std::uint64_t>::max())
      return fmt::format("'{}' is not a whole number, {} or more", text, least);
    return fmt::format("'{}' is not a whole number from {} to {}", text, least, most);
  };
}

Check share() {
  return [](const std::string& text) {
    double value = 0;
    return read_all(text, value) && 0 <= value && value <= 1 ? std::string()
                                                             : fmt::format("'{}' is not a number from 0 to 1", text);
  };
}

Check not_negative() {
  return [](const std::string& text) {
    double value = 0;
    return read_all(text, value) && 0 <= value && std::isfinite(value)
               ? std::string()
               : fmt::format("'{}' is not a number, 0 or more", text);
  };
}

Check positive() {
  return [](const std::string& text) {
    double value = 0;
    return read_all(text, value) && 0 < value && std::isfinite(value)
               ? std::string()
               : fmt::format("'{}' is not a number above 0", text);
  };
}

Check not_empty() {
  return [](const std::string& text) { return text.empty() ? std::string("the name is empty") : std::string(); };
}

Option Option::check(const Check& check) const {
  option_->check([check](const std::string& text) { return check(text); });
  return *this;
}
Option Option::required(bool is) const {
  option_->required(is);
  return *this;
}
Option Option::each(const std::function<void(const std::string& text)>& heard) const {
  option_->each(heard);
  return *this;
}
Option Option::show_default() const {
  option_->capture_default_str();
  return *this;
}
bool Option::is_given() const { return option_->count() > 0; }

Command::Command(const std::string& verb, const std::string& description, const std::string& footer)
    : app_(std::make_unique<CLI::App>(description, "isopach " + verb)), verb_(verb) {
  app_->formatter(std::make_shared<HelpFormatter>());
  app_->get_formatter()->label("OPTIONS", "options");
  app_->get_formatter()->label("Positionals", "Arguments");
  app_->footer(footer);
  app_->set_help_flag();
  app_->config_formatter(std::make_shared<ConfigFile>(*app_));
  app_->allow_config_extras(CLI::config_extras_mode::error);
}

namespace {

/// Refuses `--budget ''`, which would be looked for as a file without a name.
void refuse_empty_names(const CLI::App& app, const Arguments& arguments) {
  const auto names_a_file = [&](const std::string& word) {
    const CLI::Option* option = app.get_option_no_throw(word);
    return option != nullptr && (option->get_type_name() == "FILE" || option->get_type_name() == "DIR");
  };
  for (std::size_t i = 0; i < arguments.size(); ++i) {
    const std::string& word = arguments[i];
    const bool joined = word.size() > 1 && word.back() == '=' && names_a_file(word.substr(0, word.size() - 1));
    if (joined || (i + 1 < arguments.size() && arguments[i + 1].empty() && word.size() > 1 && word.front() == '-' &&
                   names_a_file(word)))
      throw UsageError(fmt::format("{}: the name is empty", joined ? word.substr(0, word.size() - 1) : word));
  }
}

}  // namespace

Command::~Command() = default;

template <class T>
Option Command::positional(const std::string& name, T& target, const std::string& description) {
  return Option(app_->add_option(name, target, description)->type_name("")->required());
}

template <class T>
Option Command::option(const std::string& names, const std::string& type, T& target, const std::string& description) {
  return Option(
      app_->add_option(names, target, description)->type_name(type)->group(heading_)->allow_extra_args(false));
}

// The types of values that options have.
using Words = std::vector<std::string>;
template Option Command::positional(const std::string&, std::string&, const std::string&);
template Option Command::positional(const std::string&, Words&, const std::string&);
template Option Command::option(const std::string&, const std::string&, std::string&, const std::string&);
template Option Command::option(const std::string&, const std::string&, Words&, const std::string&);
template Option Command::option(const std::string&, const std::string&, double&, const std::string&);
template Option Command::option(const std::string&, const std::string&, int&, const std::string&);
template Option Command::option(const std::string&, const std::string&, unsigned&, const std::string&);
template Option Command::option(const std::string&, const std::string&, std::uint64_t&, const std::string&);
template Option Command::option(const std::string&, const std::string&, std::optional<double>&, const std::string&);
template Option Command::option(const std::string&, const std::string&, std::optional<unsigned>&, const std::string&);
template Option Command::option(const std::string&, const std::string&, std::optional<std::size_t>&,
                                const std::string&);

Option Command::flag(const std::string& names, bool& target, const std::string& description) {
  return Option(app_->add_flag(names, target, description)->group(heading_));
}

Option Command::option_with(const std::string& names, const std::string& type,
                            const std::function<void(const std::string& text)>& read, const std::string& description,
                            const std::string& default_value) {
  CLI::Option* option = app_->add_option_function<std::string>(names, read, description)->type_name(type);
  if (!default_value.empty()) option->default_str(default_value);
  return Option(option->group(heading_));
}

std::string Command::unknown_word() const {
  std::vector<std::string> names;
  for (const CLI::Option* option : app_->get_options())
    for (const std::string& name : option->get_lnames()) names.push_back("--" + name);
  const std::vector<std::string> rest = app_->remaining();
  for (const std::string& word : rest)
    if (word.size() > 1 && word.front() == '-') {
      const std::string name = word.substr(0, word.find('='));
      return fmt::format("unknown option '{}'{}; isopach {} --help lists the options", name, did_you_mean(name, names),
                         verb_);
    }
  return rest.empty() ? "" : fmt::format("unexpected argument '{}'; see isopach {} --help", rest.front(), verb_);
}

namespace {

OptionRow row_of(const CLI::Option& option) {
  OptionRow row;
  row.names = option.get_lnames();
  row.positional = option.get_positional();
  if (row.positional) row.names = {option.get_name(false)};
  row.flag = !row.positional && option.get_items_expected_max() == 0;
  row.list = option.get_items_expected_max() > 1;
  row.required = option.get_required();
  row.heading = option.get_group();
  row.type = option.get_type_name();
  row.value = option.get_default_str();
  row.description = option.get_description();
  return row;
}

}  // namespace

bool Command::parse(const Arguments& arguments) {
  if (std::vector<OptionRow>* table = session().table) {
    for (const CLI::Option* option : app_->get_options()) table->push_back(row_of(*option));
    return false;
  }
  app_->set_help_flag("-h,--help", "Print this help and exit")->group("Run");
  app_->set_version_flag("--version", fmt::format("isopach {}", version), "Print the version and exit")->group("Run");
  app_->set_config("--config", "",
                   "Read options from FILE: lines 'name = value', # for comments; the command line wins")
      ->type_name("FILE")
      ->group("Run");
  refuse_empty_names(*app_, arguments);
  session().words.clear(), session().scan_words.clear();
  Arguments reversed(arguments.rbegin(), arguments.rend());
  try {
    app_->parse(reversed);
    for (const CLI::Option* option : app_->get_options()) {
      const auto& words = option->results();
      Session& s = session();
      if (!option->check_lname("output")) s.words.insert(s.words.end(), words.begin(), words.end());
      if (option->get_positional())
        for (const std::string& word : words) s.scan_words.push_back(name_of_scan(word));
    }
    return true;
  } catch (const CLI::CallForHelp&) {
    fmt::print("{}", app_->help());
  } catch (const CLI::CallForVersion& message) {
    fmt::print("{}\n", message.what());
  } catch (const CLI::ParseError& error) {
    const std::string unknown = unknown_word();
    if (!unknown.empty()) throw UsageError(unknown);
    const std::string text = plain_words(error, app_->get_config_ptr()->as<std::string>());
    throw UsageError(session().shell ? fmt::format("{}; see isopach {} --help", text, verb_) : text);
  }
  return false;
}

Arguments Command::given_options(const std::vector<std::string>& but) const {
  Arguments words;
  for (const CLI::Option* option : app_->get_options()) {
    const std::vector<std::string>& names = option->get_lnames();
    if (option->get_positional() || names.empty() || names.front() == "config" ||
        std::find(but.begin(), but.end(), names.front()) != but.end())
      continue;
    const bool is_flag = option->get_items_expected_max() == 0;
    for (const std::string& value : option->results()) {
      if (!is_flag)
        words.push_back("--" + names.front() + "=" + value);
      else if (value == "true")
        words.push_back("--" + names.front());
    }
  }
  return words;
}

std::uint64_t parse_size(const std::string& text, const char* option) {
  constexpr std::string_view units = "kMGT";
  std::string number = text;
  double factor = 1;
  if (const std::size_t unit = number.empty() ? units.npos : units.find(number.back()); unit != units.npos) {
    factor = std::pow(1000.0, static_cast<double>(unit + 1));
    number.pop_back();
  }
  double value = 0;
  if (!read_all(number, value) || !(value * factor >= 1) || !(value * factor < 9e18))
    throw UsageError(fmt::format("{}: '{}' is not a number of bytes, like 2500, 40k or 1.5G", option, text));
  return static_cast<std::uint64_t>(value * factor);
}

namespace {

/// Whoever asks for N threads is told if there cannot be so many; "all cores" are as many as there can be.
int threads_of(int asked) {
  const int wanted = asked > 0 ? asked : all_cores(), possible = 1 + startable_threads(wanted - 1);
  if (possible >= wanted) return asked;
  if (asked > 0)
    throw Error(ExitCode::internal,
                fmt::format("--threads {}: only {} can be started here, by its limits of processes or of memory: ask "
                            "for fewer",
                            asked, possible));
  return possible;
}

}  // namespace

void add_run_options(Command& command, RunOptions& options) {
  command.heading("Run");
  command.option("--threads", "N", options.threads, "Most threads; 0 takes all cores. The result does not depend on it")
      .check(whole_number(0, 4096))
      .show_default();
  command.option_with(
      "--max-input", "SIZE", [](const std::string& text) { set_max_input(parse_size(text, "--max-input")); },
      "Most bytes of one input file, or of what comes through a pipe: a number, or one with k, M, G or T (default half "
      "of the memory)");
  command.choice<ProgressKind>("--progress", options.progress,
                               {{"auto", ProgressKind::automatic},
                                {"bar", ProgressKind::bar},
                                {"json", ProgressKind::json},
                                {"none", ProgressKind::none}},
                               "Progress on stderr; auto: a bar on a terminal, in runs longer than a second; json: one "
                               "object a line");
  command.flag("--quiet", options.quiet,
               "No summary, no warnings, no progress: only failures, and what --json - prints");
  command.flag("--verbose", options.verbose, "The stages and when each began, on stderr");
}

void add_seed(Command& command, std::uint64_t& seed) {
  command.option("--seed", "N", seed, "Seed of the random numbers: the same seed gives the same bits")
      .check(whole_number(0))
      .show_default();
}

Run::Run(const RunOptions& options, std::uint64_t seed)
    : quiet_(options.quiet), progress_(options.quiet ? ProgressKind::none : options.progress, options.verbose) {
  context_.threads = threads_of(options.threads);
  context_.seed = seed;
  const Session& s = session();
  context_.cancelled = s.cancelled != nullptr ? s.cancelled : &interrupted();
  watch_.emplace(context_);
  context_.progress = s.progress;
  if (s.shell) context_.progress = [this](std::string_view stage, double fraction) { progress_.step(stage, fraction); };
}

void Run::say(const std::string& line) {
  if (quiet_ || !session().shell) return;
  progress_.clear();
  write_message(printable(line) + "\n");
}

void Run::warn(const std::string& warning) {
  if (const auto& heard = session().warn) heard(warning);
  say("warning: " + for_shell(warning));
}

void Run::show(const std::string& text) {
  if (!quiet_) print(printable(text));
}

void Run::print(const std::string& text) {
  if (!session().shell) return;
  progress_.clear();
  std::fwrite(text.data(), 1, text.size(), stdout);
  if (text.empty() || text.back() != '\n') std::fputc('\n', stdout);
}

}  // namespace isopach::cli
