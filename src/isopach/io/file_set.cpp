#include "isopach/io/file_set.hpp"

#include <fmt/format.h>
#include <glob.h>

#include <algorithm>
#include <array>
#include <filesystem>
#include <map>
#include <set>

#include "isopach/base/error.hpp"
#include "isopach/base/memory.hpp"
#include "isopach/io/crs.hpp"
#include "isopach/io/input_file.hpp"
#include "isopach/io/scan.hpp"
#include "isopach/io/stac.hpp"

namespace isopach {
namespace {

namespace fs = std::filesystem;

std::string extension(const std::string& path) { return lower_case(fs::path(path).extension().string()); }

bool is_catalogue_name(const std::string& path) {
  const std::string end = extension(path);
  return end == ".vpc" || end == ".json";
}

bool is_pattern(const std::string& text) {
  const std::size_t open = text.find('[');
  return text.find_first_of("*?") != std::string::npos ||
         (open != std::string::npos && text.find(']', open) != std::string::npos);
}

bool is_folder(const std::string& path) {
  std::error_code ignored;
  return fs::is_directory(path, ignored);
}
bool is_regular(const std::string& path) {
  std::error_code ignored;
  return fs::is_regular_file(path, ignored);
}
bool is_there(const std::string& path) {
  std::error_code ignored;
  return fs::exists(path, ignored);
}

std::string canonical(const std::string& path) {
  std::error_code error;
  const fs::path whole = fs::weakly_canonical(path, error);
  return error ? fs::path(path).lexically_normal().string() : whole.string();
}

// `entry` as a path, seen from the folder of `list`.
std::string beside(const std::string& list, const std::string& entry) {
  return (fs::path(list).parent_path() / entry).lexically_normal().string();
}

std::string content(const std::string& path) {
  const Context nobody_stops;
  InputFile file(path, nobody_stops);
  constexpr std::uint64_t most = std::uint64_t{256} << 20;
  if (file.size() > most)
    throw InputError(
        fmt::format("{}: more than {}: no list or catalogue of files is as large", path, bytes_in_words(most)));
  const std::span<const char> bytes = file.bytes();
  return {bytes.data(), bytes.size()};
}

std::string_view without_mark(std::string_view text) {
  return text.substr(0, 3) == "\xEF\xBB\xBF" ? text.substr(3) : text;
}

// What a line of a list names: empty for blank lines and comments.
std::string_view entry_of(std::string_view line) {
  const std::string_view entry = trimmed(line);
  return entry.substr(0, 1) == "#" ? std::string_view() : entry;
}

bool is_row_of_numbers(std::string_view line) {
  const auto fields = words(line);
  double value = 0;
  return std::all_of(fields.begin(), fields.end(), [&](std::string_view field) { return to_number(field, value); });
}

bool is_list(const std::string& path) {
  if (extension(path) != ".txt" || !is_regular(path)) return false;
  const Context nobody_stops;
  std::error_code ignored;
  if (fs::file_size(path, ignored) == 0 || ignored) return false;
  const InputFile file(path, nobody_stops);
  Lines lines(without_mark(as_text(file.head())));
  std::string_view line;
  while (lines.next(line)) {
    const std::string entry(entry_of(line));
    if (entry.empty()) continue;
    if (is_row_of_numbers(entry) || entry.find('\0') != std::string::npos) return false;
    return is_scan_name(entry) || is_catalogue_name(entry) || is_there(beside(path, entry));
  }
  return false;
}

bool is_catalogue(const std::string& path) {
  if (!is_catalogue_name(path) || !is_regular(path)) return false;
  return extension(path) == ".vpc" || content(path).find("\"stac_version\"") != std::string::npos;
}

// The points of a result lie beside it as files that would be taken for scans.
void refuse_results(const std::string& folder) {
  const Context nobody_stops;
  for (const char* const name : {"result.json", "truth.json"}) {
    const std::string path = (fs::path(folder) / name).string();
    std::error_code ignored;
    if (!is_regular(path) || fs::file_size(path, ignored) == 0) continue;
    const InputFile file(path, nobody_stops);
    if (as_text(file.head()).find("\"isopach.") == std::string_view::npos) continue;
    throw InputError(
        fmt::format("{}: the folder holds a result of isopach ({}): name the scans in it, e.g. by a pattern",
                    printable(folder), name));
  }
}

std::vector<std::string> scans_in(const std::string& folder) {
  refuse_results(folder);
  std::vector<std::string> found;
  std::error_code failure;
  for (const auto& entry : fs::directory_iterator(folder, failure)) {
    const std::string path = entry.path().string(), end = extension(path);
    if (is_scan_name(path) && end != ".txt" && end != ".csv" && is_regular(path)) found.push_back(path);
  }
  if (failure)
    throw InputError(fmt::format("{}: the folder cannot be read ({})", printable(folder), failure.message()));
  if (found.empty())
    throw InputError(
        fmt::format("{}: no scan in this folder: it holds none of .las, .laz, .ply, .xyz, .tif, …; name "
                    ".txt and .csv files by a pattern, '*.txt'",
                    printable(folder)));
  return found;
}

std::vector<std::string> matches(const std::string& pattern) {
  glob_t found{};
  const int answer = ::glob(pattern.c_str(), GLOB_NOSORT, nullptr, &found);
  std::vector<std::string> paths(found.gl_pathv, found.gl_pathv + (answer == 0 ? found.gl_pathc : 0));
  ::globfree(&found);
  std::erase_if(paths, is_folder);
  if (paths.empty())
    throw InputError(fmt::format("{}: no file has such a name: check the pattern", printable(pattern)));
  return paths;
}

// Collects files from lists of lists.
class Finder {
 public:
  // `where` begins a message about the entry: the word itself, or list and entry.
  void add(const std::string& path, const std::string& where) {
    if (is_folder(path))
      add_files(scans_in(path), where);
    else if (is_list(path))
      within(path, [&] { add_list(path); });
    else if (is_catalogue(path))
      within(path, [&] { add_catalogue(path); });
    else if (!is_there(path) && is_pattern(path))
      add_files(matches(path), where);
    else
      add_file(path, where);
  }

  std::vector<std::string> sorted() {
    std::vector<std::string> paths;
    for (auto& [place, path] : files_) paths.push_back(std::move(path));
    return paths;
  }

 private:
  void add_file(const std::string& path, const std::string& where) {
    const auto [known, is_new] = files_.emplace(canonical(path), path);
    if (!is_new)
      throw InputError(fmt::format("{}: the file {} is named twice: name it once", where, printable(known->second)));
  }

  void add_files(const std::vector<std::string>& paths, const std::string& where) {
    for (const std::string& path : paths) add_file(path, where);
  }

  void add_entry(const std::string& list, const std::string& entry) {
    const std::string where = fmt::format("{}: {}", list, printable(entry));
    if (entry.find("://") != std::string::npos)
      throw InputError(where + ": addresses are not read: download the file and name its path");
    const std::string path = beside(list, entry);
    if (!is_there(path) && !is_pattern(entry)) throw InputError(where + ": no such file: check the path");
    add(path, where);
  }

  void add_list(const std::string& list) {
    const std::string text = content(list);
    Lines lines(without_mark(text));
    std::string_view line;
    while (lines.next(line)) {
      const std::string_view entry = entry_of(line);
      if (entry.find('\0') != std::string_view::npos)
        throw InputError(fmt::format("{}: line {}: not the name of a file: correct the list", list, lines.number()));
      if (!entry.empty()) add_entry(list, std::string(entry));
    }
  }

  void add_catalogue(const std::string& catalogue) {
    for (const std::string& href : stac_hrefs(content(catalogue), catalogue)) {
      const std::string path = path_of_href(href);
      const std::string plain = is_there(beside(catalogue, path)) ? path : decoded(path);
      add_entry(catalogue, plain);
    }
  }

  // Runs `work` while `list` is open: it must not be met again before it is closed.
  template <class Work>
  void within(const std::string& list, Work&& work) {
    constexpr std::size_t deepest = 32;
    const std::string place = canonical(list);
    if (!open_.insert(place).second)
      throw InputError(fmt::format("{}: the list contains itself: remove the entry", printable(list)));
    if (open_.size() > deepest) throw InputError(fmt::format("{}: lists in lists in lists: name files", list));
    work();
    open_.erase(place);
  }

  std::map<std::string, std::string> files_;  // canonical path: path
  std::set<std::string> open_;
};

bool differ(const std::string& one, const std::string& other) {
  return one != "unknown" && other != "unknown" && one != other;
}

// Drops the attributes of `all` that `part` has not, and appends points and values.
void append(Cloud& all, const Cloud& part, std::set<std::string>& dropped) {
  const auto note_those_without = [&](const Cloud& has, const Cloud& other) {
    for (const Attribute& attribute : has.attributes)
      if (other.find_attribute(attribute.name) == nullptr) dropped.insert(attribute.name);
  };
  note_those_without(all, part);
  note_those_without(part, all);
  std::erase_if(all.attributes, [&](const Attribute& a) { return dropped.contains(a.name); });
  all.points.insert(all.points.end(), part.points.begin(), part.points.end());
  for (Attribute& attribute : all.attributes) {
    const Array<double>& more = part.find_attribute(attribute.name)->values;
    attribute.values.insert(attribute.values.end(), more.begin(), more.end());
  }
  all.nodata += part.nodata;
}

void refuse_too_large(const std::vector<std::string>& files, const std::string& name) {
  std::uint64_t bytes = 0;
  for (const std::string& file : files) {
    std::error_code ignored;
    const std::uint64_t size = fs::file_size(file, ignored);
    if (!ignored) bytes += size;
  }
  if (bytes > max_input())
    throw InputError(
        fmt::format("{}: its {} files hold {}, the limit of @max-input is {} (by default half of the "
                    "memory): name fewer of them, or raise the limit",
                    name, files.size(), bytes_in_words(bytes), bytes_in_words(max_input())));
}

}  // namespace

bool is_scan_name(const std::string& path) {
  constexpr std::array<std::string_view, 16> known{".las", ".laz", ".ply", ".xyz", ".txt",  ".csv", ".pts", ".ptx",
                                                   ".obj", ".stl", ".pcd", ".tif", ".tiff", ".asc", ".img", ".grd"};
  return std::find(known.begin(), known.end(), extension(path)) != known.end();
}

bool is_file_set(const std::string& what) {
  return is_folder(what) || is_list(what) || is_catalogue(what) || (is_pattern(what) && !is_there(what));
}

std::vector<std::string> files_of(const std::string& what) {
  Finder finder;
  finder.add(what, what);
  return finder.sorted();
}

void join_systems(ScanSystem& all, const ScanSystem& other) {
  const auto refuse = [&](const char* what, const std::string& one, const std::string& two) {
    throw InputError(fmt::format("{}: {} {}, but that of {} is {}: convert the files to one, or name those of one",
                                 other.path, what, two, all.path, one));
  };
  if (!same_crs(all.crs, other.crs)) refuse("its CRS is", short_name(all.crs), short_name(other.crs));
  if (differ(all.unit, other.unit)) refuse("its unit is", all.unit, other.unit);
  if (differ(all.vertical_unit, other.vertical_unit))
    refuse("its unit of heights is", all.vertical_unit, other.vertical_unit);
  if (all.crs.empty()) all.crs = other.crs;
  if (all.unit == "unknown") all.unit = other.unit;
  if (all.vertical_unit == "unknown") all.vertical_unit = other.vertical_unit;
}

std::vector<std::string> join_notes(const std::vector<FileNotes>& files) {
  if (files.size() == 1) return files.front().notes;
  struct Row {
    std::string text, path;
    std::size_t files;
  };
  std::vector<Row> rows;
  std::map<std::string, std::size_t> places;
  for (const FileNotes& file : files)
    for (const std::string& note : file.notes) {
      const std::string own = note.starts_with(file.path + ": ") ? note.substr(file.path.size() + 2) : note;
      const auto [at, is_new] = places.emplace(own, rows.size());
      if (is_new) rows.push_back({own, file.path, 0});
      ++rows[at->second].files;
    }
  constexpr std::size_t most = 20;
  std::vector<std::string> joined;
  for (std::size_t k = 0; k < std::min(most, rows.size()); ++k) {
    const Row& row = rows[k];
    joined.push_back(row.files == 1 ? fmt::format("{}: {}", row.path, row.text)
                                    : fmt::format("{} and {} more: {}", row.path, row.files - 1, row.text));
  }
  if (rows.size() > most) joined.push_back(fmt::format("{} more notes on its files", rows.size() - most));
  return joined;
}

Cloud read_set(const std::vector<std::string>& files, const std::string& name, const ReadOptions& options,
               const Context& context) {
  if (files.size() == 1) return read_cloud(files.front(), options, context);
  refuse_too_large(files, name);
  ReadOptions points = options;
  points.faces = false;
  Cloud all;
  ScanSystem system;
  std::vector<FileNotes> told;
  std::set<std::string> dropped;
  for (const std::string& file : files) {
    Cloud part = read_cloud(file, points, context);
    const ScanSystem own{file, part.unit, part.vertical_unit, part.crs};
    told.push_back({file, part.notes});
    if (&file == &files.front()) {
      all = std::move(part), system = own;
      continue;
    }
    join_systems(system, own);
    append(all, part, dropped);
  }
  all.path = name, all.format = "set";
  all.unit = system.unit, all.vertical_unit = system.vertical_unit, all.crs = system.crs;
  all.grid.reset(), all.notes.clear(), all.faces.clear();
  for (const std::string& attribute : dropped)
    all.notes.push_back(fmt::format("not all of its files have {}, which is left out", attribute));
  for (const std::string& note : join_notes(told)) all.notes.push_back(note);
  return all;
}

}  // namespace isopach
