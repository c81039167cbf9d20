#include "isopach/report/draw/palette.hpp"

#include <algorithm>
#include <array>
#include <cmath>

#include "isopach/base/error.hpp"
#include "isopach/report/report.hpp"

namespace isopach {
namespace {

constexpr std::size_t half = 512;  // table entries on either side of white

struct Stop {
  double at, lightness, chroma;
};
// The same stops for every hue: equal lightness and chroma either side.
constexpr std::array<Stop, 4> stops{{{0.0, 1.0, 0.0}, {0.30, 0.87, 0.06}, {0.70, 0.64, 0.125}, {1.0, 0.43, 0.12}}};

struct Hues {
  const char* name;
  double first_degrees, second_degrees;
  double chroma;  // of the stops' chroma, so that both hues stay inside sRGB
};
constexpr std::array<Hues, 3> hue_pairs{
    {{"blue-red", 252, 29, 1.0}, {"purple-orange", 300, 60, 0.75}, {"teal-brown", 195, 50, 0.6}}};

double linear(double v) { return v <= 0.04045 ? v / 12.92 : std::pow((v + 0.055) / 1.055, 2.4); }
double gamma(double v) {
  v = std::clamp(v, 0.0, 1.0);
  return v <= 0.0031308 ? 12.92 * v : 1.055 * std::pow(v, 1 / 2.4) - 0.055;
}

Rgb from_oklab(double light, double a, double b) {
  const double l = std::pow(light + 0.3963377774 * a + 0.2158037573 * b, 3);
  const double m = std::pow(light - 0.1055613458 * a - 0.0638541728 * b, 3);
  const double s = std::pow(light - 0.0894841775 * a - 1.2914855480 * b, 3);
  return {gamma(4.0767416621 * l - 3.3077115913 * m + 0.2309699292 * s),
          gamma(-1.2684380046 * l + 2.6097574011 * m - 0.3413193965 * s),
          gamma(-0.0041960863 * l - 0.7034186147 * m + 1.7076147010 * s)};
}

Rgb colour_at(double t, double hue_degrees, double chroma_share) {
  if (t == 0) return {1, 1, 1};
  std::size_t k = 1;
  while (k + 1 < stops.size() && stops[k].at < t) ++k;
  const Stop &from = stops[k - 1], &to = stops[k];
  const double s = (t - from.at) / (to.at - from.at);
  const double light = from.lightness + s * (to.lightness - from.lightness);
  const double chroma = chroma_share * (from.chroma + s * (to.chroma - from.chroma));
  const double hue = hue_degrees * 3.14159265358979323846 / 180;
  return from_oklab(light, chroma * std::cos(hue), chroma * std::sin(hue));
}

}  // namespace

double lightness(const Rgb& c) {
  const double r = linear(c.r), g = linear(c.g), b = linear(c.b);
  return 0.2104542553 * std::cbrt(0.4122214708 * r + 0.5363325363 * g + 0.0514459929 * b) +
         0.7936177850 * std::cbrt(0.2119034982 * r + 0.6806995451 * g + 0.1073969566 * b) -
         0.0040720468 * std::cbrt(0.0883024619 * r + 0.2817188376 * g + 0.6299787005 * b);
}

Palette::Palette(const std::string& name, bool flip) {
  const auto pair = std::find_if(hue_pairs.begin(), hue_pairs.end(), [&](const Hues& p) { return name == p.name; });
  if (pair == hue_pairs.end()) {
    std::string known;
    for (const std::string& p : palettes()) known += (known.empty() ? "" : ", ") + p;
    throw UsageError("@palette " + name + ": unknown; use one of " + known);
  }
  const double above = flip ? pair->second_degrees : pair->first_degrees;
  const double below = flip ? pair->first_degrees : pair->second_degrees;
  table_.resize(2 * half + 1);
  for (std::size_t i = 0; i <= half; ++i) {
    const double t = static_cast<double>(i) / half;
    table_[half + i] = colour_at(t, above, pair->chroma);
    table_[half - i] = colour_at(t, below, pair->chroma);
  }
}

const Rgb& Palette::operator()(double t) const {
  const double clamped = std::isnan(t) ? 0 : std::clamp(t, -1.0, 1.0);
  return table_[static_cast<std::size_t>(std::lround(clamped * half) + static_cast<long>(half))];
}

bool paints_excess_red(const std::string& unit) { return unit == "mm"; }

std::vector<std::string> palettes() {
  std::vector<std::string> names;
  for (const Hues& p : hue_pairs) names.emplace_back(p.name);
  return names;
}

}  // namespace isopach
