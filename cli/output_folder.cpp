// OutputFolder: a result is written into a folder within the one it is for, and put in place by renaming. What is to be
// renamed is written down first, so that the next run can finish what was cut short.
#include <fcntl.h>
#include <fmt/core.h>
#include <sys/file.h>
#include <sys/stat.h>
#include <unistd.h>

#include <algorithm>
#include <cerrno>
#include <cstring>
#include <nlohmann/json.hpp>

#include "cli/input_words.hpp"
#include "cli/output.hpp"
#include "isopach/base/error.hpp"
#include "isopach/io/input_file.hpp"
#include "isopach/io/output_file.hpp"

namespace isopach::cli {
namespace fs = std::filesystem;

namespace {

/// What stands at `path` itself, not where a link leads. Throws where the disk does not tell: what is there must not be
/// taken for missing.
fs::file_type kind_of(const fs::path& path) {
  std::error_code error;
  const fs::file_type kind = fs::symlink_status(path, error).type();
  if (kind == fs::file_type::none) fail_to_write(path.string(), error.message());
  return kind;
}

bool is_there(const fs::path& path) { return kind_of(path) != fs::file_type::not_found; }

/// A JSON file of ours or of others; null where there is none or it is no JSON. Throws where it cannot be read: what it
/// lists would be taken for files of the user.
nlohmann::json json_in(const fs::path& path) {
  std::error_code error;
  const fs::file_type kind = fs::status(path, error).type();
  if (kind == fs::file_type::none) fail_to_write(path.string(), error.message());
  if (kind != fs::file_type::regular || fs::file_size(path, error) == 0) return {};
  const Context nobody_stops;
  InputFile file(path.string(), nobody_stops);
  const std::span<const char> bytes = file.bytes();
  nlohmann::json json = nlohmann::json::parse(bytes.begin(), bytes.end(), nullptr, false);
  return json.is_discarded() ? nlohmann::json() : json;
}

/// What an earlier run says in `record` that it wrote; nothing where that is no record of isopach.
std::vector<std::string> outputs_of(const fs::path& record) {
  const nlohmann::json json = json_in(record);
  if (!json.is_object()) return {};
  const auto schema = json.find("schema"), outputs = json.find("outputs");
  if (schema == json.end() || !schema->is_string() || schema->get<std::string>().rfind("isopach.", 0) != 0) return {};
  if (outputs == json.end() || !outputs->is_array()) return {};
  std::vector<std::string> names;
  for (const nlohmann::json& name : *outputs)
    if (name.is_string()) names.push_back(name.get<std::string>());
  return names;
}

/// A name within the folder, and no way out of it.
bool is_plain_name(const std::string& name) {
  return !name.empty() && name != "." && name != ".." && name.find_first_of("/\\:") == std::string::npos &&
         name.find('\0') == std::string::npos;
}

bool is_named(const fs::path& file, const std::vector<std::string>& words) {
  return std::any_of(words.begin(), words.end(), [&](const std::string& word) {
    std::error_code error;
    const bool same = fs::equivalent(word, file, error);
    if (error == std::errc::io_error) fail_to_write(file.string(), error.message());
    return same && !error;
  });
}

bool holds(const std::vector<std::string>& names, const std::string& name) {
  return std::find(names.begin(), names.end(), name) != names.end();
}

/// Names that the record of an earlier run lists and this one does not write, of regular files that are no input of
/// this one.
std::vector<std::string> left_over(const fs::path& folder, const std::string& record,
                                   const std::vector<std::string>& written) {
  const std::vector<std::string>& words = input_words();
  std::vector<std::string> names;
  if (is_named(folder, words)) return names;  // a folder of scans that gets its own result
  for (const std::string& name : outputs_of(folder / record)) {
    if (!is_plain_name(name) || holds(written, name)) continue;
    if (kind_of(folder / name) != fs::file_type::regular) continue;
    if (!is_named(folder / name, words)) names.push_back(name);
  }
  return names;
}

// What a commit does, as it stands in the file "commit.json" of the unfinished folder while it is done.
struct Plan {
  std::vector<std::string> put;     ///< new files, the record of the result last
  std::vector<std::string> remove;  ///< files of the earlier result that the new one does not have
};

constexpr const char* schema_of_plan = "isopach.commit/1";

void write_plan(const Plan& plan, const fs::path& staging) {
  const nlohmann::ordered_json json{{"schema", schema_of_plan}, {"put", plan.put}, {"remove", plan.remove}};
  write_text_atomically((staging / "commit.json").string(),
                        json.dump(2, ' ', false, nlohmann::ordered_json::error_handler_t::replace) + "\n");
}

std::optional<Plan> plan_in(const fs::path& staging) {
  const fs::path path = staging / "commit.json";
  if (kind_of(path) != fs::file_type::regular) return std::nullopt;
  const nlohmann::json json = json_in(path);
  if (!json.is_object() || json.value("schema", nlohmann::json()) != schema_of_plan) return std::nullopt;
  Plan plan;
  for (const auto& [key, names] : {std::pair{"put", &plan.put}, std::pair{"remove", &plan.remove}})
    for (const nlohmann::json& name : json.value(key, nlohmann::json()))
      if (name.is_string() && is_plain_name(name.get<std::string>())) names->push_back(name.get<std::string>());
  return plan;
}

void move(const fs::path& from, const fs::path& to) {
  std::error_code error;
  fs::rename(from, to, error);
  if (error) fail_to_write(to.string(), error.message());
}

void refuse_if_folder(const fs::path& folder, const std::string& name) {
  if (kind_of(folder / name) == fs::file_type::directory)
    throw UsageError(fmt::format("--output {}: {} is a folder there, and a file of the result: choose another folder",
                                 folder.string(), name));
}

// Puts a plan into effect, or takes it back. Both look at what is there, not at what they did: they can be cut short at
// any moment and begun again.
class Commit {
 public:
  Commit(fs::path folder, const fs::path& staging, Plan plan)
      : folder_(std::move(folder)), new_(staging / "new"), old_(staging / "old"), plan_(std::move(plan)) {}

  // The record of the earlier result goes first and that of the new one comes last: a record stands beside no files but
  // those it lists.
  void apply() const {
    std::error_code ignored;
    fs::create_directory(old_, ignored);
    if (!plan_.put.empty() && is_there(new_ / plan_.put.back())) set_aside(plan_.put.back());
    for (const std::string& name : plan_.remove)
      if (!is_there(old_ / name)) set_aside(name);
    for (const std::string& name : plan_.put) {
      if (!is_there(new_ / name)) continue;
      set_aside(name);
      move(new_ / name, folder_ / name);
    }
    put_on_disk(folder_.string());
  }

  void take_back() const {
    for (auto name = plan_.put.rbegin(); name != plan_.put.rend(); ++name) {
      if (!is_there(new_ / *name) && is_there(folder_ / *name)) move(folder_ / *name, new_ / *name);
      restore(*name);
    }
    for (const std::string& name : plan_.remove) restore(name);
  }

 private:
  void set_aside(const std::string& name) const {
    refuse_if_folder(folder_, name);  // what is set aside will be removed, and no folder ever is
    if (is_there(folder_ / name)) move(folder_ / name, old_ / name);
  }
  void restore(const std::string& name) const {
    if (is_there(old_ / name)) move(old_ / name, folder_ / name);
  }

  fs::path folder_, new_, old_;
  Plan plan_;
};

void remove_staging(const fs::path& staging) {
  std::error_code ignored;
  fs::remove(staging / "commit.json", ignored);  // first: without it what is left is rubbish
  fs::remove_all(staging, ignored);
}

// What killed runs left: a commit that was decided is finished, all else goes. Only with the lock of the folder.
void finish_earlier_runs(const fs::path& folder) {
  std::error_code error;
  std::vector<fs::path> left;
  for (fs::directory_iterator entry(folder, error), end; !error && entry != end; entry.increment(error))
    if (is_unfinished_folder(entry->path().filename().string()) && kind_of(entry->path()) == fs::file_type::directory)
      left.push_back(entry->path());
  if (error) fail_to_write(folder.string(), error.message());  // a commit that is overlooked would be done later
  for (const fs::path& staging : left) {
    if (const auto plan = plan_in(staging)) Commit(folder, staging, *plan).apply();
    remove_staging(staging);
  }
  sweep_unfinished_files(folder.string(), "");
}

[[noreturn]] void refuse_folder(const std::string& folder, int error) {
  if (error == ENOSPC || error == EDQUOT || error == EIO || error == EMFILE || error == ENFILE || error == ENOMEM)
    fail_to_write(folder, std::strerror(error));
  throw UsageError(
      fmt::format("--output {}: cannot be written to ({}); choose another folder", folder, std::strerror(error)));
}

/// A lock on the folder itself, which leaves no file behind. Where a file system has none, -1: then nothing is swept.
int lock_folder(const fs::path& folder) {
  const int descriptor = ::open(folder.c_str(), O_RDONLY | O_DIRECTORY | O_CLOEXEC);
  if (descriptor < 0) refuse_folder(folder.string(), errno);
  if (::flock(descriptor, LOCK_EX | LOCK_NB) == 0) return descriptor;
  const int error = errno;
  ::close(descriptor);
  if (error == EWOULDBLOCK)
    throw UsageError(fmt::format(
        "--output {}: another run is writing into this folder: wait for it to end, or choose another folder",
        folder.string()));
  return -1;
}

}  // namespace

OutputFolder::OutputFolder(const std::string& folder) : folder_(folder), staging_(folder_ / unfinished_name()) {
  std::error_code error;
  if (fs::exists(folder_, error) && !fs::is_directory(folder_, error))
    throw UsageError(fmt::format("--output {}: is a file, not a folder", folder));
  std::vector<fs::path> missing;
  for (fs::path p = fs::absolute(folder_).lexically_normal(); !p.empty() && !fs::exists(p, error); p = p.parent_path())
    missing.push_back(p);
  made_.assign(missing.rbegin(), missing.rend());
  try {
    fs::create_directories(folder_, error);
    if (error) refuse_folder(folder, error.value());
    lock_ = lock_folder(folder_);
    if (lock_ >= 0) finish_earlier_runs(folder_);
    fs::create_directories(staging_ / "new", error);
    if (error) refuse_folder(folder, error.value());
  } catch (...) {
    clear();
    throw;
  }
}

OutputFolder::~OutputFolder() { clear(); }

void OutputFolder::clear() noexcept {
  std::error_code ignored;
  if (!half_done_) remove_staging(staging_);
  for (auto p = made_.rbegin(); p != made_.rend(); ++p) fs::remove(*p, ignored);  // removes empty folders only
  if (lock_ >= 0) ::close(lock_);
  lock_ = -1;
}

std::string OutputFolder::path(const std::string& name) {
  names_.push_back(name);
  return (staging_ / "new" / name).string();
}

void OutputFolder::write_text(const std::string& name, const std::string& text) {
  write_text_atomically(path(name), text);
}

// A folder holds one result: the files that an earlier run listed in its record and this one does not write go. Nothing
// else is ever removed: no file outside the folder, no folder, no link, no input of this run.
void OutputFolder::commit() {
  const std::string record = holds(names_, "result.json") ? "result.json" : "truth.json";  // of simulate
  Plan plan{names_, left_over(folder_, record, names_)};
  std::stable_partition(plan.put.begin(), plan.put.end(), [&](const std::string& name) { return name != record; });
  for (const std::string& name : plan.put) refuse_if_folder(folder_, name);
  put_on_disk((staging_ / "new").string());
  write_plan(plan, staging_);
  put_on_disk(staging_.string());
  put_on_disk(folder_.string());
  const Commit commit(folder_, staging_, plan);
  half_done_ = true;  // until it is done or taken back the next run must find the plan
  try {
    commit.apply();
  } catch (...) {  // where this fails as well, as it may without memory, the next run finishes the commit
    commit.take_back();
    half_done_ = false;
    throw;
  }
  half_done_ = false;
  remove_staging(staging_);
}

}  // namespace isopach::cli
