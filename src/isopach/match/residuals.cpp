#include "isopach/match/residuals.hpp"

#include <algorithm>
#include <cmath>
#include <limits>

#include "isopach/base/parallel.hpp"
#include "isopach/base/sum.hpp"
#include "isopach/overlay/localise.hpp"

namespace isopach {

namespace {

constexpr double huber_bound = 1.345, tukey_bound = 4.685;
constexpr double patch_bound = 4;           // scales of the patches' means
constexpr double median_to_sigma = 1.4826;  // of a normal distribution
constexpr std::size_t block = 4096;
static_assert(block % Residuals::largest_patch == 0);

/// Loss and weight (its derivative over n).
struct Valued {
  double loss, weight;
};
Valued value(const Loss& loss, double n) {
  if (loss.kind == Loss::Kind::huber) {
    const double k = huber_bound * loss.scale, a = std::fabs(n);
    if (a <= k) return {0.5 * n * n, 1};
    return {k * (a - 0.5 * k), k / a};
  }
  const double c = tukey_bound * loss.scale, u = n / c, v = 1 - u * u;
  if (v <= 0) return {c * c / 6, 0};
  return {c * c / 6 * (1 - v * v * v), v * v};
}

/// The plane of one facet: height at the corner, slope.
struct Facet {
  double z = 0, gx = 0, gy = 0;
  double noise_xx = 0, noise_xy = 0, noise_yy = 0;  // Σ over corners of ∇λ ∇λᵀ
};

// False for facets too thin to have a slope.
bool facet_at(const MatchSurface& s, Index triangle, const Point2& q, Facet& f) {
  const auto& v = s.t.triangles[triangle].v;
  const Point2 &a = s.xy[v[0]], &b = s.xy[v[1]], &c = s.xy[v[2]];
  const double bx = b.x - a.x, by = b.y - a.y, cx = c.x - a.x, cy = c.y - a.y;
  const double twice = bx * cy - by * cx;
  if (!(twice > 1e-9 * (bx * bx + by * by + cx * cx + cy * cy))) return false;
  const double zb = s.z[v[1]] - s.z[v[0]], zc = s.z[v[2]] - s.z[v[0]];
  f.gx = (zb * cy - zc * by) / twice;
  f.gy = (zc * bx - zb * cx) / twice;
  f.z = s.z[v[0]] + f.gx * (q.x - a.x) + f.gy * (q.y - a.y);
  return true;
}

void slope_noise(const MatchSurface& s, Index triangle, Facet& f) {
  const auto& v = s.t.triangles[triangle].v;
  const Point2 &a = s.xy[v[0]], &b = s.xy[v[1]], &c = s.xy[v[2]];
  const double bx = b.x - a.x, by = b.y - a.y, cx = c.x - a.x, cy = c.y - a.y;
  const double twice = bx * cy - by * cx;
  const double lx[3] = {(by - cy) / twice, cy / twice, -by / twice};
  const double ly[3] = {(cx - bx) / twice, -cx / twice, bx / twice};
  f.noise_xx = f.noise_xy = f.noise_yy = 0;
  for (int k = 0; k < 3; ++k) f.noise_xx += lx[k] * lx[k], f.noise_xy += lx[k] * ly[k], f.noise_yy += ly[k] * ly[k];
}

/// One node over a facet: residual, and its derivative by the scaled parameters.
struct Row {
  double n = 0, vertical = 0, cosine = 1;
  Vector7 j{};
  Point3 arm{0, 0, 0};
};

// The surfaces as seen from one side: nodes are taken into the target's coordinates.
struct View {
  const ResidualSide& side;
  const Motion& motion;
  const Point3& centre;
  double inverse_length;

  [[nodiscard]] Point3 node(std::size_t i) const {
    return {side.nodes->xy[i].x, side.nodes->xy[i].y, side.nodes->z[i]};
  }
  [[nodiscard]] Row row(const Point3& own, const Point3& there, const Facet& f) const {
    Row r;
    const double inverse = 1 / std::sqrt(1 + f.gx * f.gx + f.gy * f.gy);
    r.cosine = inverse;
    r.vertical = there.z - f.z;
    Point3 normal{-f.gx * inverse, -f.gy * inverse, inverse}, place = there;
    double sign = 1, size = 1;
    if (!side.moving_nodes) {  // the surface moves under the node
      normal = motion.turn(normal);
      place = own;
      sign = -1;
      size = motion.scale;
    }
    r.n = r.vertical * inverse * size;
    r.vertical *= size;
    const Point3 arm{(place.x - centre.x) * inverse_length, (place.y - centre.y) * inverse_length,
                     (place.z - centre.z) * inverse_length};
    r.arm = arm;
    r.j[0] = sign * (arm.y * normal.z - arm.z * normal.y);
    r.j[1] = sign * (arm.z * normal.x - arm.x * normal.z);
    r.j[2] = sign * (arm.x * normal.y - arm.y * normal.x);
    r.j[3] = sign * normal.x;
    r.j[4] = sign * normal.y;
    r.j[5] = sign * normal.z;
    r.j[6] = sign * (arm.x * normal.x + arm.y * normal.y + arm.z * normal.z);
    if (!side.moving_nodes) r.j[6] += r.n * inverse_length;  // what grows is the surface under the node
    return r;
  }
};

/// Where the node is: the triangle, or nothing if the target has no surface there.
bool locate_again(const MatchSurface& target, const Point2& q, Index& hint, std::uint64_t& visited) {
  const Location found = locate(q, target.t, target.xy, hint, visited);
  return found.kind != Location::Kind::outside && found.kind != Location::Kind::none && !target.t.is_ghost(hint) &&
         target.footprint.keeps(hint);
}

void add_to(ResidualSums& total, const ResidualSums& part) {
  total.h.add(part.h);
  for (std::size_t k = 0; k < parameters; ++k) total.b[k] += part.b[k];
  total.area += part.area;
  total.trusted += part.trusted;
  total.loss += part.loss;
  total.fitted += part.fitted;
  total.volume += part.volume;
  total.within += part.within;
  total.squares += part.squares;
  total.visited += part.visited;
}

ResidualSums evaluate_side(ResidualSide& side, const Motion& motion, const Loss& loss, const Point3& centre,
                           double length, std::size_t patch) {
  const View view{side, motion, centre, 1 / length};
  return reduce_blocks<ResidualSums>(
      side.nodes->xy.size(), block,
      [&](std::size_t begin, std::size_t end) {
        ResidualSums sums;
        Index last = 0;
        for (std::size_t i = begin; i < end; ++i) {
          side.n[i] = std::numeric_limits<double>::quiet_NaN();
          const double area = side.nodes->weight[i];
          if (!(area > 0)) continue;
          const Point3 own = view.node(i), there = side.moving_nodes ? motion.apply(own) : motion.undo(own);
          const Point2 q{there.x, there.y};
          if (side.hint[i] == no_index) side.hint[i] = last;
          const bool over = locate_again(*side.target, q, side.hint[i], sums.visited);
          last = side.hint[i];
          Facet facet;
          if (!over || !facet_at(*side.target, last, q, facet)) continue;
          const Row row = view.row(own, there, facet);
          side.n[i] = row.n;
          const Valued v = value(loss, row.n);
          const double trusted = area * side.trust[i / patch], weight = trusted * v.weight;
          sums.area += area;
          sums.trusted += trusted;
          sums.loss += trusted * v.loss;
          if (weight == 0) continue;
          sums.within += trusted;
          sums.fitted += weight;
          sums.volume += trusted * std::fabs(row.vertical);
          sums.squares += weight * row.vertical * row.vertical;
          sums.h.add(row.j, weight);
          for (std::size_t k = 0; k < parameters; ++k) sums.b[k] -= weight * row.n * row.j[k];
        }
        return sums;
      },
      add_to);
}

}  // namespace

Residuals::Residuals(const MatchSurface& moving, const MatchSurface& fixed, const Point3& centre, double length)
    : centre_(centre), length_(length) {
  const std::size_t fewest = std::min(moving.xy.size(), fixed.xy.size());
  patch_ = largest_patch;
  while (patch_ > 1 && fewest / patch_ < 64) patch_ /= 2;
  sides_[0] = {&moving, &fixed, true, {}, {}, {}};
  sides_[1] = {&fixed, &moving, false, {}, {}, {}};
  for (ResidualSide& side : sides_) {
    const std::size_t n = side.nodes->xy.size();
    side.hint.assign(n, no_index);
    side.n.assign(n, std::numeric_limits<double>::quiet_NaN());
    side.trust.assign((n + patch_ - 1) / patch_, 1.0);
  }
}

Twist Residuals::twist(const Vector7& step) const {
  return {step[0] / length_, step[1] / length_, step[2] / length_, step[3], step[4], step[5], step[6] / length_};
}

ResidualSums Residuals::evaluate(const Motion& motion, const Loss& loss, const Context& context) {
  context.check();
  ResidualSums parts[2];
  if (sides_[0].target->t.real == 0 || sides_[1].target->t.real == 0) return parts[0];
  both([&] { parts[0] = evaluate_side(sides_[0], motion, loss, centre_, length_, patch_); },
       [&] { parts[1] = evaluate_side(sides_[1], motion, loss, centre_, length_, patch_); });
  add_to(parts[0], parts[1]);
  return parts[0];
}

double Residuals::spread() const {
  constexpr std::size_t enough = 50000;  // of each side: the median of these is good to half a per cent
  std::vector<double> sizes;
  for (const ResidualSide& side : sides_) {
    const std::size_t stride = 1 + side.n.size() / enough;
    for (std::size_t i = 0; i < side.n.size(); i += stride)
      if (!std::isnan(side.n[i]) && side.trust[i / patch_] > 0) sizes.push_back(std::fabs(side.n[i]));
  }
  if (sizes.empty()) return 0;
  const auto middle = sizes.begin() + static_cast<std::ptrdiff_t>(sizes.size() / 2);
  std::nth_element(sizes.begin(), middle, sizes.end());
  return median_to_sigma * *middle;
}

bool Residuals::fitted(std::size_t i, const Loss& loss) const {
  const double n = sides_[0].n[i];
  return !std::isnan(n) && sides_[0].trust[i / patch_] * value(loss, n).weight > 0;
}

std::vector<Residuals::PatchMean> Residuals::patch_means() const {
  std::vector<PatchMean> means;
  for (std::size_t s = 0; s < 2; ++s) {
    const ResidualSide& side = sides_[s];
    for (std::size_t p = 0; p < side.trust.size(); ++p) {
      PatchMean m{0, 0, s, p};
      std::size_t count = 0;
      const std::size_t end = std::min(side.n.size(), (p + 1) * patch_);
      for (std::size_t i = p * patch_; i < end; ++i) {
        if (std::isnan(side.n[i])) continue;
        m.mean += side.nodes->weight[i] * side.n[i];
        m.area += side.nodes->weight[i];
        ++count;
      }
      if (count == 0) continue;
      m.mean /= m.area;
      if (count < patch_ / 2) m.mean *= std::sqrt(static_cast<double>(2 * count) / static_cast<double>(patch_));
      means.push_back(m);
    }
  }
  return means;
}

void Residuals::trust_all() {
  for (ResidualSide& side : sides_) std::fill(side.trust.begin(), side.trust.end(), 1.0);
}

void Residuals::trust_by_mean() {
  std::vector<PatchMean> means = patch_means();
  if (means.empty()) return;
  std::vector<double> sizes;
  for (const PatchMean& m : means) sizes.push_back(std::fabs(m.mean));
  const auto middle = sizes.begin() + static_cast<std::ptrdiff_t>(sizes.size() / 2);
  std::nth_element(sizes.begin(), middle, sizes.end());
  const double bound = patch_bound * median_to_sigma * *middle;
  for (const PatchMean& m : means) {
    const double u = bound > 0 ? m.mean / bound : (m.mean == 0 ? 0 : 1), v = 1 - u * u;
    sides_[m.side].trust[m.patch] = v > 0 ? v * v : 0;
  }
}

void Residuals::trust_share(double share) {
  std::vector<PatchMean> means = patch_means();
  double all = 0, used = 0;
  for (const PatchMean& m : means) all += m.area;
  std::sort(means.begin(), means.end(), [](const PatchMean& a, const PatchMean& b) {
    const double x = std::fabs(a.mean), y = std::fabs(b.mean);
    return x < y || (x == y && (a.side < b.side || (a.side == b.side && a.patch < b.patch)));
  });
  for (const PatchMean& m : means) {
    sides_[m.side].trust[m.patch] = used < share * all ? 1 : 0;
    used += m.area;
  }
}

Information Residuals::information(const Motion& motion, const Loss& loss, double noise, const Context& context) {
  context.check();
  Information total;
  for (ResidualSide& side : sides_) {
    const View view{side, motion, centre_, 1 / length_};
    const auto add = [](Information& sum, const Information& part) {
      sum.h.add(part.h);
      sum.score.add(part.score);
      sum.noise.add(part.noise);
    };
    add(total, reduce_blocks<Information>(
                   side.nodes->xy.size(), block,
                   [&](std::size_t begin, std::size_t end) {
                     Information part;
                     std::uint64_t visited = 0;
                     Vector7 score{};
                     for (std::size_t i = begin; i < end; ++i) {
                       if (i % patch_ == 0) part.score.add(score, 1), score.fill(0);
                       const double trusted = side.nodes->weight[i] * side.trust[i / patch_];
                       if (!(trusted > 0) || std::isnan(side.n[i])) continue;
                       const Point3 own = view.node(i),
                                    there = side.moving_nodes ? motion.apply(own) : motion.undo(own);
                       const Point2 q{there.x, there.y};
                       Facet facet;
                       if (!locate_again(*side.target, q, side.hint[i], visited) ||
                           !facet_at(*side.target, side.hint[i], q, facet))
                         continue;
                       const Row row = view.row(own, there, facet);
                       const double weight = trusted * value(loss, row.n).weight;
                       part.h.add(row.j, weight);
                       for (std::size_t k = 0; k < parameters; ++k) score[k] -= weight * row.j[k] * row.n;
                       slope_noise(*side.target, side.hint[i], facet);
                       // n depends on the slope g through J = d(−g, 1)·motion: only its x and y parts carry noise.
                       const Vector7 along_x{0, -row.arm.z, row.arm.y, 1, 0, 0, row.arm.x};
                       const Vector7 along_y{row.arm.z, 0, -row.arm.x, 0, 1, 0, row.arm.y};
                       Vector7 both_ways;
                       for (std::size_t k = 0; k < parameters; ++k) both_ways[k] = along_x[k] + along_y[k];
                       const double s = weight * noise * noise * row.cosine * row.cosine;
                       part.noise.add(along_x, s * (facet.noise_xx - facet.noise_xy));
                       part.noise.add(along_y, s * (facet.noise_yy - facet.noise_xy));
                       part.noise.add(both_ways, s * facet.noise_xy);
                     }
                     part.score.add(score, 1);
                     return part;
                   },
                   add));
  }
  return total;
}

}  // namespace isopach
