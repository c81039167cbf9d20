#include "isopach/base/option_key.hpp"

#include <algorithm>
#include <iterator>

namespace isopach {
namespace {

/// The options that messages name, sorted. scripts/checks/words.py holds it to the messages, tests/cli/warnings_test.py
/// to the options of the command line.
constexpr std::string_view option_keys[] = {
    "accept-doubt",
    "across",
    "align",
    "allow-crs",
    "alpha",
    "border",
    "budget",
    "change-height",
    "changes",
    "class",
    "coarse",
    "confidence",
    "contours",
    "core-points",
    "correlation-range",
    "crop",
    "currents-error",
    "degree",
    "depth",
    "direction",
    "domain",
    "exclude",
    "extent",
    "filter",
    "filter-degree",
    "folds",
    "follow",
    "form",
    "freedom",
    "include",
    "interpolation",
    "l-filter",
    "least-part",
    "least-share",
    "lod",
    "logo",
    "margin",
    "mask",
    "match",
    "max-depth",
    "max-edge",
    "max-input",
    "max-iterations",
    "measure",
    "mesh",
    "min-change-area",
    "min-change-volume",
    "min-coverage",
    "model-points",
    "no-cells",
    "noise-floor",
    "normal-scale",
    "objective",
    "one-to-one",
    "outlines",
    "overlap",
    "pair-weights",
    "palette",
    "pose",
    "profile",
    "projection-scale",
    "raster",
    "rate",
    "reference",
    "reference-sigma",
    "regions",
    "registration-error",
    "reject-boundary",
    "reject-distance",
    "reject-normal",
    "rim",
    "s-filter",
    "samples",
    "sigma",
    "sigma1",
    "sigma2",
    "smooth",
    "stable",
    "start",
    "start-face",
    "start-jaw",
    "static-at",
    "surface",
    "symmetric",
    "tolerance",
    "uncertainty-model",
    "unit",
    "visible",
    "weight",
    "within",
    "wrinkle-depth",
    "wrinkle-length",
};
static_assert(std::is_sorted(std::begin(option_keys), std::end(option_keys)));

/// ASCII alone: not what a locale takes for a letter.
constexpr bool is_lower(char c) { return 'a' <= c && c <= 'z'; }
constexpr bool is_letter_or_digit(char c) { return is_lower(c) || ('A' <= c && c <= 'Z') || ('0' <= c && c <= '9'); }
constexpr bool is_of_key(char c) { return is_lower(c) || ('0' <= c && c <= '9') || c == '-'; }
/// Bytes above 127 are letters of UTF-8.
constexpr bool is_of_name(char c) {
  return is_letter_or_digit(c) || c == '_' || c == '/' || static_cast<unsigned char>(c) > 127;
}

bool may_stand_before(char c) {
  return !is_of_name(c) && std::string_view(".-@'\"`").find(c) == std::string_view::npos;
}

/// Length of the key behind an @ at `at` of the text; 0 if there is none.
std::size_t key_length(std::string_view text, std::size_t at) {
  if (at > 0 && !may_stand_before(text[at - 1])) return 0;
  const std::size_t begin = at + 1;
  std::size_t end = begin;
  while (end < text.size() && is_of_key(text[end])) ++end;
  if (!is_option_key(text.substr(begin, end - begin))) return 0;
  if (end == text.size()) return end - begin;
  const bool ending = text[end] == '.' && end + 1 < text.size() && is_of_name(text[end + 1]);  // "@mask.ply"
  return ending || is_of_name(text[end]) || text[end] == '@' ? 0 : end - begin;
}

template <class Spell>
std::string spelled(const std::string& text, const Spell& spell) {
  std::string out;
  std::size_t done = 0;
  for (std::size_t at = text.find('@'); at != std::string::npos; at = text.find('@', at + 1)) {
    const std::size_t length = key_length(text, at);
    if (length == 0) continue;
    out.append(text, done, at - done);
    out += spell(text.substr(at + 1, length));
    done = at + 1 + length;
  }
  return out.append(text, done);
}

}  // namespace

bool is_option_key(std::string_view key) {
  return std::binary_search(std::begin(option_keys), std::end(option_keys), key);
}

std::string for_shell(std::string text) {
  return spelled(text, [](const std::string& key) { return "--" + key; });
}

std::string for_keywords(std::string text) {
  return spelled(text, [](std::string key) {
    std::replace(key.begin(), key.end(), '-', '_');
    return key;
  });
}

std::string leading_key(std::string_view text) {
  return text.starts_with('@') ? std::string(text.substr(1, key_length(text, 0))) : std::string();
}

}  // namespace isopach
