#include "cli/session.hpp"

#include <algorithm>
#include <cctype>

#include "cli/answer.hpp"
#include "cli/input_words.hpp"
#include "isopach/io/file_set.hpp"
#include "isopach/io/polygons.hpp"

namespace isopach::cli {
namespace {

Session& of_shell() {
  static Session shell;
  return shell;
}

thread_local Session* current = nullptr;

/// As much of a scan in memory as the reader of a file would have kept.
CloudView part_of(CloudView scan, const ReadOptions& wanted) {
  if (!wanted.faces) scan.faces = {};
  if (!wanted.all_attributes)
    std::erase_if(scan.attributes, [&](const AttributeView& attribute) {
      return std::find(wanted.attributes.begin(), wanted.attributes.end(), attribute.name) == wanted.attributes.end();
    });
  return scan;
}

/// A scan of one file, or of the files of a folder, pattern, list or catalogue: they are words of the run then, too.
Cloud read_named(const std::string& word, const ReadOptions& wanted, const Context& context) {
  if (!is_file_set(word)) return read_cloud(word, wanted, context);
  const std::vector<std::string> files = files_of(word);
  session().words.insert(session().words.end(), files.begin(), files.end());
  return read_set(files, word, wanted, context);
}

}  // namespace

Session& session() { return current != nullptr ? *current : of_shell(); }

SessionScope::SessionScope(Session& own) : before_(current) { current = &own; }
SessionScope::~SessionScope() { current = before_; }

const std::vector<std::string>& input_words() { return session().words; }
const std::vector<std::string>& scan_words() { return session().scan_words; }

CloudView scan_named(const std::string& word, const ReadOptions& wanted, const Context& context) {
  const auto& scans = session().scans;
  if (const auto found = scans.find(word); found != scans.end()) return part_of(found->second, wanted);
  return read_named(word, wanted, context);
}

Cloud cloud_named(const std::string& word, const ReadOptions& wanted, const Context& context) {
  const auto& scans = session().scans;
  if (const auto found = scans.find(word); found != scans.end()) return copy_of(part_of(found->second, wanted));
  return read_named(word, wanted, context);
}

std::string name_of_scan(const std::string& word) {
  const auto& scans = session().scans;
  const auto found = scans.find(word);
  return found != scans.end() ? found->second.path : word;
}

PolygonSet polygons_named(const std::string& word) {
  const auto& polygons = session().polygons;
  if (const auto found = polygons.find(word); found != polygons.end()) return found->second;
  return read_polygons(word);
}

bool has_polygons(const std::string& word) { return session().polygons.contains(word); }

std::string naming_a_scan(const std::string& message) {
  const std::vector<std::string>& scans = scan_words();
  const auto stands_there = [&](const std::string& word) { return message.find(word) != std::string::npos; };
  const auto is_letter = [](unsigned char c) { return std::isalpha(c) != 0; };
  const auto is_named_path = [&](const std::string& word) {  // of an option: a number is none
    return word.find_first_of("./") != std::string::npos && std::any_of(word.begin(), word.end(), is_letter) &&
           stands_there(word);
  };
  if (std::any_of(scans.begin(), scans.end(), [&](const std::string& word) {
        return session().shell ? stands_there(word) : message.starts_with(word + ": ");  // "a" stands in every message
      }))
    return message;
  if (std::any_of(input_words().begin(), input_words().end(), is_named_path)) return message;
  constexpr std::size_t most = 4;
  std::string names;
  for (std::size_t k = 0; k < std::min(most, scans.size()); ++k) names += (names.empty() ? "" : ", ") + scans[k];
  if (scans.size() > most) names += ", …";
  return names.empty() ? message : names + ": " + message;
}

}  // namespace isopach::cli
