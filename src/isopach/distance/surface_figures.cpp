#include "isopach/distance/surface_figures.hpp"

#include <algorithm>
#include <cmath>

#include "isopach/base/parallel.hpp"
#include "isopach/base/random.hpp"
#include "isopach/base/sum.hpp"
#include "isopach/distance/vectors.hpp"

namespace isopach {
namespace {

constexpr std::size_t block = 256;
constexpr double set = 3, sets = 2;  // samples of a set, sets of a part
constexpr double least_growth = 1.5, growth_reserve = 1.2, most_growth = 64;

using Corners = std::array<Point3, 3>;

/// Sums over parts of faces.
struct Part {
  Sum mean, squares;                    // integrals of the distance and its square
  Sum mean_variance, squares_variance;  // of these
  std::size_t samples = 0;
  double max2 = 0;

  void add(const Part& other) {
    mean.add(other.mean), squares.add(other.squares);
    mean_variance.add(other.mean_variance), squares_variance.add(other.squares_variance);
    samples += other.samples;
    max2 = std::max(max2, other.max2);
  }
};

/// Means of distance and square over a set.
struct SetMeans {
  double distance = 0, square = 0;
};

/// u, v: uniform in [0, 1).
SetMeans measure_set(const Corners& c, double u, double v, const SurfaceTree& other, Part& part) {
  if (u + v > 1) u = 1 - u, v = 1 - v;
  const double share[3] = {1 - u - v, u, v};
  SetMeans means;
  for (std::size_t turn = 0; turn < 3; ++turn) {
    const Point3 at = share[turn] * c[0] + share[(turn + 1) % 3] * c[1] + share[(turn + 2) % 3] * c[2];
    const double d2 = other.closest(at).at.distance2;
    means.distance += std::sqrt(d2) / set, means.square += d2 / set;
    part.max2 = std::max(part.max2, d2);
  }
  part.samples += 3;
  return means;
}

void measure_part(const Corners& c, double area, const RandomStream& random, std::uint64_t& drawn,
                  const SurfaceTree& other, Part& part) {
  SetMeans m[2];
  for (SetMeans& of_set : m) {
    of_set = measure_set(c, random.uniform(drawn), random.uniform(drawn + 1), other, part);
    drawn += 2;
  }
  const double distance = area * (m[0].distance - m[1].distance) / 2, square = area * (m[0].square - m[1].square) / 2;
  part.mean.add(area * (m[0].distance + m[1].distance) / 2);
  part.squares.add(area * (m[0].square + m[1].square) / 2);
  part.mean_variance.add(distance * distance);
  part.squares_variance.add(square * square);
}

void measure_face(const Corners& c, double area, double k, const RandomStream& random, const SurfaceTree& other,
                  Part& part) {
  const Point3 u = (1 / k) * (c[1] - c[0]), v = (1 / k) * (c[2] - c[0]);
  const auto at = [&](double s, double t) { return c[0] + s * u + t * v; };
  std::uint64_t drawn = 0;
  for (double s = 0; s < k; ++s)
    for (double t = 0; s + t < k; ++t) {
      measure_part({at(s, t), at(s + 1, t), at(s, t + 1)}, area / (k * k), random, drawn, other, part);
      if (s + t + 1 < k)
        measure_part({at(s + 1, t + 1), at(s, t + 1), at(s + 1, t)}, area / (k * k), random, drawn, other, part);
    }
}

double area_of(const Mesh& mesh) {
  return reduce_blocks<Sum>(
             mesh.faces.size(), block,
             [&](std::size_t begin, std::size_t end) {
               Sum area;
               for (std::size_t i = begin; i < end; ++i) area.add(face_area(mesh.corners(i)));
               return area;
             },
             [](Sum& total, const Sum& part) { total.add(part); })
      .value();
}

/// `pass`: its random numbers are not those of the others.
SurfaceFigures measure_surface(const Mesh& mesh, const SurfaceTree& other, double area, double samples,
                               std::uint64_t pass, const Context& context) {
  context.check();
  const double parts_per_area = samples / (set * sets) / area;
  const Part total = reduce_blocks<Part>(
      mesh.faces.size(), block,
      [&](std::size_t begin, std::size_t end) {
        Part part;
        for (std::size_t i = begin; i < end; ++i) {
          context.check();  // a face may have all the samples
          const Corners c = mesh.corners(i);
          const double face = face_area(c), k = std::max(1.0, std::ceil(std::sqrt(face * parts_per_area)));
          measure_face(c, face, k, RandomStream(pass, i), other, part);
        }
        return part;
      },
      [](Part& sum, const Part& part) { sum.add(part); });
  SurfaceFigures f;
  f.area = area;
  f.samples = total.samples;
  f.mean = total.mean.value() / area;
  f.rms = std::sqrt(total.squares.value() / area);
  f.max = std::sqrt(total.max2);
  f.mean_error = std::sqrt(total.mean_variance.value()) / area;
  f.rms_error = f.rms > 0 ? std::sqrt(total.squares_variance.value()) / area / (2 * f.rms) : 0;
  return f;
}

}  // namespace

SurfaceFigures surface_figures(const Mesh& mesh, const SurfaceTree& other, const SurfaceSampling& sampling,
                               const Context& context) {
  const double area = area_of(mesh);
  if (!(area > 0)) return {};
  const auto most = static_cast<double>(sampling.most);
  double samples = std::max(static_cast<double>(sampling.per_face) * static_cast<double>(mesh.faces.size()),
                            std::min(static_cast<double>(sampling.least), most));
  for (std::uint64_t pass = 1;; ++pass) {
    const SurfaceFigures f = measure_surface(mesh, other, area, samples, pass, context);
    const auto off = [&](double error, double value) {  // against what is asked for
      return error <= sampling.rounding ? 0 : error / (sampling.error * value);
    };
    const double worst = std::max(off(f.mean_error, f.mean), off(f.rms_error, f.rms));
    if (!(worst > 1)) return f;
    // n times as many parts are 1/√n as wide, and what the distance varies by in a part falls with its width: so the
    // standard error falls by n and not by √n.
    const auto taken = static_cast<double>(f.samples);
    const double growth = std::min(std::clamp(growth_reserve * worst, least_growth, most_growth), most / taken);
    if (growth < least_growth) return f;
    samples = growth * std::max(taken, samples);
  }
}

}  // namespace isopach
