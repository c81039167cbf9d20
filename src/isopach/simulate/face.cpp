// A face seen from the front: x to the viewer's right, y up, z to the viewer, mm; the origin lies between eyes and nose
// tip. Smooth and symmetric in x. The second scan differs by a swelling of one cheek, of known volume.
#include <cmath>
#include <numbers>

#include "isopach/simulate/bump.hpp"
#include "isopach/simulate/model.hpp"

namespace isopach {
namespace {

double bell(double t) { return std::exp(-0.5 * t * t); }
double window(double t) { return std::exp(-(t * t) * (t * t)); }  // flatter than a bell
double step(double t) { return 0.5 + 0.5 * std::tanh(t); }        // 0 far below, 1 far above

/// A hill (or hollow) of the face. Those beside the middle exist twice, at ±x.
struct Feature {
  double x, y, width, length, z;
  [[nodiscard]] double at(double px, double py) const {
    const double u = (px - x) / width, v = (py - y) / length;
    return z * std::exp(-0.5 * (u * u + v * v));
  }
};

constexpr Feature middle[] = {
    {0, 62, 42, 26, 5},      // forehead
    {0, 31, 7, 7, -3},       // root of the nose
    {0, -10, 8, 7, 6},       // tip of the nose
    {0, -29, 2.6, 5, -1.2},  // philtrum
    {0, -42, 24, 15, 6},     // mouth region
    {0, -49, 12, 3.6, 4.5},  // lower lip
    {0, -59, 16, 4, -3},     // below the lip
    {0, -75, 16, 11, 9},     // chin
};

constexpr Feature sides[] = {
    {31, 26, 14, 10, -10},   // eye socket
    {31, 25, 8.5, 6.5, 7},   // eyeball
    {13, -15, 4.5, 5.5, 7},  // wing of the nose
    {6, -21, 2.5, 1.8, -3},  // nostril
    {50, 0, 18, 15, 6},      // cheekbone
    {46, -42, 16, 18, -2},   // cheek
    {7, -37, 6, 2.8, 3},     // upper lip
    {14, -38, 8, 3, 2},      // upper lip, outer half
    {27, -43, 4, 4, -1.5},   // corner of the mouth
    {78, 45, 14, 22, -5},    // temple
};

double head(double x, double y) {
  const double jaw = 1 + 0.16 * step((-45 - y) / 25);  // narrower below
  const double u = jaw * x / 100, v = (y - 4) / 150;
  const double neck = 24 * step((x * x / 90 - 99 - y) / 9);  // behind the jaw line
  return 92 * std::sqrt(1.18 - u * u - v * v) - neck;
}

double nose(double x, double y) {
  const double ridge = 20 * step((6 - y) / 24) * step((y + 20) / 3.2);
  const double width = 6 + 4 * step((-2 - y) / 9);
  return ridge * bell(x / width);
}

/// Brow, lid fold and closed lids of one eye; x is measured towards its own side.
double eye(double x, double y) {
  const double t = x - 31;
  const double brow = 4.5 * bell((y - 42 + t * t / 150) / 4.5) * bell((x - 26) / 15);
  const double fold = -1.1 * bell((y - 32.5 + t * t / 40) / 1.3) * window(t / 12);
  const double lids = -1.6 * bell((y - 22.5 - t * t / 75) / 1.1) * window(t / 12);
  return brow + fold + lids;
}

double mouth_line(double x, double y) {
  const double line = -43.5 + 1.6 * bell(x / 4) - 1.2 * bell((x - 10) / 6) - 1.2 * bell((x + 10) / 6);
  return -3.2 * window(x / 24) * bell((y - line) / 1.5);
}

double fold(double x, double y) {  // from the wing of the nose to beside the mouth
  const double down = -14 - y;
  const double line = 19 + 0.2 * down + 0.006 * down * down;
  return -1.1 * bell((x - line) / 3) * bell((y + 27) / 8);
}

double face(double x, double y) {
  double z = head(x, y) + nose(x, y) + mouth_line(x, y);
  for (const Feature& f : middle) z += f.at(x, y);
  for (const double own : {x, -x}) {
    z += eye(own, y) + fold(own, y);
    for (const Feature& f : sides) z += f.at(own, y);
  }
  return z;
}

constexpr Bump swelling{{45, -31}, 6, 30, 26, {0.6, 0.8}, 0, 0};

double height(int, int epoch, double x, double y) { return face(x, y) + (epoch == 1 ? 0 : swelling.at(x, y)); }

/// An oval of 176 mm by 236 mm.
Outline footprint(int, const SceneOptions&) {
  constexpr int corners = 48;
  Outline oval;
  for (int i = 0; i < corners; ++i) {
    const double angle = 2 * std::numbers::pi * i / corners;
    oval.push_back({88 * std::cos(angle), 118 * std::sin(angle) - 2});
  }
  return oval;
}

Truth truth(int, const Outline& footprint) {
  Truth truth;
  truth.area = polygon_area(footprint);
  truth.above = truth.net = swelling.volume();
  truth.parts = {{"swelling", swelling.volume()}};
  return truth;
}

/// First scanner: structured light, a fine raster. Second: hand-held, coarse and irregular.
Array<Point2> nodes(int epoch, const Outline& footprint, std::size_t count, std::uint64_t seed) {
  const Draw draw{seed, static_cast<std::uint64_t>(epoch)};
  if (epoch == 2) return irregular_nodes(footprint, count, draw);
  return scan_nodes(footprint, count, {0.02, 1, 0, false, 1, 0.1}, draw);
}

}  // namespace

SceneModel face_scene() {
  SceneModel model;
  model.name = "face";
  model.description = "a face by two scanners, one fine and one coarse: in the second scan one cheek is swollen";
  model.unit = "mm";
  model.defaults.points_a = 120000;
  model.defaults.points_b = 40000;
  model.defaults.noise_a = 0.03;
  model.defaults.noise_b = 0.1;
  model.least_points = 100;
  model.height = height;
  model.footprint = footprint;
  model.truth = truth;
  model.nodes = nodes;
  return model;
}

}  // namespace isopach
