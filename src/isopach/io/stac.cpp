#include "isopach/io/stac.hpp"

#include <fmt/format.h>

#include <charconv>
#include <nlohmann/json.hpp>

#include "isopach/base/error.hpp"
#include "isopach/io/file_set.hpp"

namespace isopach {
namespace {

using Json = nlohmann::json;

[[noreturn]] void fail(const std::string& path, const std::string& cause) {
  throw InputError(fmt::format("{}: {}: check the catalogue", path, cause));
}

// Deep nesting costs memory before it is seen to be senseless.
Json parsed(const std::string& text, const std::string& path) {
  constexpr int deepest = 100;
  const auto look = [&](int depth, Json::parse_event_t, Json&) {
    if (depth > deepest) fail(path, "its JSON is nested too deeply");
    return true;
  };
  Json json = Json::parse(text, look, false);
  if (json.is_discarded()) fail(path, "it is no JSON, or cut short");
  return json;
}

// A member that is a text; empty if it is not there or something else.
std::string text_in(const Json& json, const char* key) {
  if (!json.is_object()) return "";
  const auto found = json.find(key);
  return found != json.end() && found->is_string() ? found->get<std::string>() : "";
}

// A member that has members, or values; null if it is not there or something else.
const Json& part_of(const Json& json, const char* key) {
  static const Json none;
  if (!json.is_object()) return none;
  const auto found = json.find(key);
  return found != json.end() && found->is_structured() ? *found : none;
}

bool has_role(const Json& asset, const char* role) {
  for (const Json& own : part_of(asset, "roles"))
    if (own == role) return true;
  return false;
}

void add_item(const Json& item, const std::string& path, std::vector<std::string>& hrefs) {
  const Json& assets = part_of(item, "assets");
  const std::size_t before = hrefs.size();
  const auto add_where = [&](auto&& is_meant) {
    if (hrefs.size() > before || !assets.is_object()) return;
    for (const auto& [name, asset] : assets.items()) {
      const std::string href = text_in(asset, "href");
      if (!href.empty() && is_meant(name, asset, href)) hrefs.push_back(href);
    }
  };
  add_where([](const std::string& name, const Json&, const std::string&) { return name == "data"; });
  add_where([](const std::string&, const Json& asset, const std::string&) { return has_role(asset, "data"); });
  add_where([](const std::string&, const Json&, const std::string& href) { return is_scan_name(href); });
  if (hrefs.size() == before)
    fail(path, fmt::format("item {}: no asset of it is a scan", printable(text_in(item, "id"))));
}

}  // namespace

std::vector<std::string> stac_hrefs(const std::string& text, const std::string& path) {
  const Json json = parsed(text, path);
  const std::string type = text_in(json, "type");
  std::vector<std::string> hrefs;
  if (type == "FeatureCollection")
    for (const Json& item : part_of(json, "features")) add_item(item, path, hrefs);
  else if (type == "Feature")
    add_item(json, path, hrefs);
  else if (type == "Catalog" || type == "Collection")
    for (const Json& link : part_of(json, "links")) {
      const std::string relation = text_in(link, "rel"), href = text_in(link, "href");
      if ((relation == "item" || relation == "child") && !href.empty()) hrefs.push_back(href);
    }
  else
    fail(path, "it is no STAC item, collection of items or catalogue");
  if (hrefs.empty()) fail(path, "it names no files");
  for (const std::string& href : hrefs)
    if (href.find('\0') != std::string::npos) fail(path, fmt::format("{} is no name of a file", printable(href)));
  return hrefs;
}

std::string path_of_href(const std::string& href) {
  constexpr std::string_view local = "file://";
  return href.starts_with(local) ? href.substr(local.size()) : href;
}

std::string decoded(const std::string& href) {
  std::string out;
  for (std::size_t i = 0; i < href.size(); ++i) {
    unsigned char byte = 0;
    const char* const digits = href.data() + i + 1;
    if (href[i] == '%' && i + 2 < href.size() && std::from_chars(digits, digits + 2, byte, 16).ptr == digits + 2 &&
        byte != 0)
      out += static_cast<char>(byte), i += 2;
    else
      out += href[i];
  }
  return out;
}

std::string printable(const std::string& text) {
  constexpr std::size_t most = 200;
  std::string out = text.substr(0, most);
  for (char& c : out)
    if (static_cast<unsigned char>(c) < ' ' || c == '\x7F') c = '?';
  return out;
}

}  // namespace isopach
