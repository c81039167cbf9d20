// What surrounds a run of a verb: the shell, or a program that holds scans, poses and polygons in memory where a
// command line names files. The options and what becomes of them are the same for both.
#pragma once
#include <atomic>
#include <cstdint>
#include <functional>
#include <map>
#include <memory>
#include <string>
#include <string_view>
#include <vector>

#include "isopach/base/context.hpp"
#include "isopach/cloud/cloud_view.hpp"
#include "isopach/geom/polygons.hpp"
#include "isopach/geom/rigid.hpp"
#include "isopach/io/read.hpp"

namespace isopach::cli {

class Answer;

/// One option of a verb, as it is declared: what help and other front ends are made from.
struct OptionRow {
  std::vector<std::string> names;  ///< long names without dashes; of an argument its name
  bool positional = false, flag = false, list = false, required = false;
  std::string heading, type;
  std::string value;  ///< default, as a word; empty: none, or as the description says
  std::string description;
};

/// One for each run, of the thread that runs it: what a word names is known to all that read words, and two programs'
/// threads do not see each other's.
struct Session {
  // Given by a program: a word among the arguments that is a key here names the value, not a file.
  bool shell = true;                             ///< false: nothing is printed, answers are handed over
  std::map<std::string, CloudView> scans;        ///< their paths are their names in messages and results
  std::map<std::string, Pose> poses;             ///< of --pose, --start, …
  std::map<std::string, std::string> matchings;  ///< texts of match_json, of --registration-error
  std::map<std::string, PolygonSet> polygons;    ///< of --include, --exclude, --budget, --regions
  const std::atomic<bool>* cancelled = nullptr;  ///< null: that of the shell's signals
  std::function<void(std::string_view stage, double fraction)> progress;  ///< empty: as --progress says
  std::function<void(const std::string& warning)> warn;                   ///< as the library words it, see for_shell

  /// Where the options that a verb declares are asked for: it is filled in place of a run.
  std::vector<OptionRow>* table = nullptr;

  // Found by the run.
  std::vector<std::string> words, scan_words;  ///< see input_words.hpp
  std::unique_ptr<Answer> answer;              ///< where `shell` is false
};

/// The session of this thread; at first that of a shell.
[[nodiscard]] Session& session();

/// Makes `own` the session of this thread as long as it lives.
class SessionScope {
 public:
  explicit SessionScope(Session& own);
  ~SessionScope();
  SessionScope(const SessionScope&) = delete;
  SessionScope& operator=(const SessionScope&) = delete;

 private:
  Session* before_;
};

/// The scan that `word` names: one of the session, of which nothing is copied and only what `wanted` asks for is shown,
/// or that of a file, or of several as files_of finds them. Errors: as of read_cloud, files_of and read_set.
[[nodiscard]] CloudView scan_named(const std::string& word, const ReadOptions& wanted, const Context& context);

/// The same as a cloud with arrays of its own: that of the file, or a copy.
[[nodiscard]] Cloud cloud_named(const std::string& word, const ReadOptions& wanted, const Context& context);

/// The name of a scan in messages: its path, also of one of the session.
[[nodiscard]] std::string name_of_scan(const std::string& word);

/// Polygons of the session, or of a file. Errors: as of read_polygons.
[[nodiscard]] PolygonSet polygons_named(const std::string& word);

/// Whether the session holds polygons of that name.
[[nodiscard]] bool has_polygons(const std::string& word);

}  // namespace isopach::cli
