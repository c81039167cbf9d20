#include "isopach/match/surface/patch.hpp"

namespace isopach {

namespace {

enum class Seen { inside, beyond_0, beyond_1, beyond_2, unsure };

/// On which side of a facet the place lies: inside, or beyond its side 0, 1 or 2, if the shares of the corners tell it
/// by more than the rounding of their single precision can have made of them. What is not certain goes to the exact
/// predicates.
[[gnu::always_inline]] inline Seen look(const Facet& f, const Point3& place) {
  const auto x = static_cast<float>(place.x - f.x), y = static_cast<float>(place.y - f.y);
  constexpr float rounding = 1.0F / (1 << 18);
  const float bx = f.bx * x, by = f.by * y, cx = f.cx * x, cy = f.cy * y;
  const float b = bx + by, c = cx + cy, a = 1 - b - c;
  const float bound = rounding * (1 + std::fabs(bx) + std::fabs(by) + std::fabs(cx) + std::fabs(cy));
  const float least = std::min(std::min(b, c), a);
  if (least > bound) return Seen::inside;
  if (!(least < -bound)) return Seen::unsure;  // also the NaN and the zeros of what is no facet
  return least == c ? Seen::beyond_0 : least == a ? Seen::beyond_1 : Seen::beyond_2;
}

/// The triangle or ghost there.
Index beyond(const MatchSurface& s, Index triangle, Seen side) {
  return triangle_of(s.t.triangles[triangle].n[static_cast<std::size_t>(side) - 1]);
}

/// Where the node is, from the triangle it was in before: over facets as long as they tell where to go, then by exact
/// predicates. False where there is no surface.
bool locate_again(const MatchSurface& target, const Point2& q, Index& hint, std::uint64_t& visited) {
  constexpr int most_facets = 8;
  for (int i = 0; i < most_facets && hint < target.t.real; ++i) {
    const Seen seen = look(target.facets[hint], {q.x, q.y, 0});
    if (seen == Seen::unsure) break;
    ++visited;
    if (seen == Seen::inside) return true;
    hint = beyond(target, hint, seen);
  }
  const Location found = locate(q, target.t, target.xy, hint, visited);
  return found.kind != Location::Kind::outside && found.kind != Location::Kind::none && hint < target.t.real &&
         target.facets[hint].exists();
}

/// Weight, loss and second derivative of the loss of each residual. One loop without branches each.
void value_huber(double k, std::size_t count, const double* n, double* loss, double* weight, double* curvature) {
  for (std::size_t i = 0; i < count; ++i) {
    const double a = std::fabs(n[i]), beyond = k * (a - 0.5 * k), share = k / a, within = 0.5 * n[i] * n[i];
    const bool is_within = a <= k;
    loss[i] = is_within ? within : beyond;
    weight[i] = is_within ? 1 : share;
    curvature[i] = is_within ? 1 : 0;
  }
}
void value_tukey(double c, std::size_t count, const double* n, double* loss, double* weight, double* curvature) {
  const double inverse = 1 / (c * c), top = c * c / 6;
  for (std::size_t i = 0; i < count; ++i) {
    const double u2 = n[i] * n[i] * inverse, left = 1 - u2, v = left > 0 ? left : 0;
    weight[i] = v * v;
    loss[i] = top * (1 - v * v * v);
    curvature[i] = v * (1 - 5 * u2);
  }
}

}  // namespace

View::View(const ResidualSide& side, const Motion& motion, const Point3& middle, double length)
    : centre(middle), inverse_length(1 / length), turn(motion.rotation) {
  const auto& r = motion.rotation;
  const double s = motion.scale, w = 1 / motion.scale;
  const Point3& t = motion.shift;
  if (side.moving_nodes) {
    m = {s * r[0], s * r[1], s * r[2], t.x, s * r[3], s * r[4], s * r[5], t.y, s * r[6], s * r[7], s * r[8], t.z};
  } else {
    const Point3 back = motion.undo({0, 0, 0});
    m = {w * r[0], w * r[3], w * r[6], back.x,   w * r[1], w * r[4],
         w * r[7], back.y,   w * r[2], w * r[5], w * r[8], back.z};
    size = s;
  }
}

void PatchRows::find(ResidualSide& side, const View& view, std::size_t begin, std::size_t end, Index& last,
                     std::uint64_t& visited) {
  const MatchSurface &nodes = *side.nodes, &target = *side.target;
  const Facet* facets = target.facets.data();
  const float* factors = side.factors();
  const Index real = target.t.real;
  const std::size_t all = nodes.xy.size();
  std::size_t moved = 0;
  count_ = 0;
  for (std::size_t i = begin; i < end; ++i) {
    const std::size_t later = ahead_of(i, end);
    if (later < all && side.hint[later] < real) {
      prefetch(facets + side.hint[later]);
      prefetch(factors + side.hint[later]);
    }
    side.n[i] = std::numeric_limits<double>::quiet_NaN();
    if (!(nodes.weight[i] > 0)) continue;
    const std::size_t k = count_++;
    const Point3 there = there_[k] = view.there({nodes.xy[i].x, nodes.xy[i].y, nodes.z[i]});
    node_[k] = static_cast<Index>(i);
    Index& at = side.hint[i];
    if (at == no_index) {
      at = last;
      is_over_[k] = locate_again(target, {there.x, there.y}, at, visited);
    } else if (at < real && look(facets[at], there) == Seen::inside) {
      ++visited;
      is_over_[k] = true;
    } else {  // later, when memory has answered
      if (at < real) prefetch(&target.t.triangles[at]);
      moved_[moved++] = k;
    }
    last = at;
  }
  for (std::size_t m = 0; m < moved; ++m) {
    const std::size_t k = moved_[m];
    Index& at = side.hint[node_[k]];
    if (at >= real) continue;
    const Seen seen = look(facets[at], there_[k]);
    if (seen == Seen::unsure) continue;
    ++visited;
    at = beyond(target, at, seen);
    if (at < real) prefetch(facets + at);
  }
  for (std::size_t m = 0; m < moved; ++m) {
    const std::size_t k = moved_[m];
    is_over_[k] = locate_again(target, {there_[k].x, there_[k].y}, side.hint[node_[k]], visited);
  }
}

template <bool moving_nodes>
void PatchRows::gather(ResidualSide& side, const View& view, std::size_t begin, std::size_t end, Index& last,
                       std::uint64_t& visited) {
  find(side, view, begin, end, last, visited);
  const MatchSurface &nodes = *side.nodes, &target = *side.target;
  std::size_t k = 0;
  for (std::size_t found = 0; found < count_; ++found) {
    if (!is_over_[found]) continue;
    const Index i = node_[found], at = side.hint[i];
    const Point3 there = there_[found];
    const Facet& f = target.facets[at];
    const Point3 arm = view.arm(moving_nodes ? there : Point3{nodes.xy[i].x, nodes.xy[i].y, nodes.z[i]});
    const ResidualRow row = side.row[i] = {(there.z - f.height(there.x, there.y)) * view.size,
                                           static_cast<float>(arm.x),
                                           static_cast<float>(arm.y),
                                           static_cast<float>(arm.z),
                                           f.smooth_gx,
                                           f.smooth_gy};
    take(side, k, i, row);
    ++k;
  }
  count_ = k;
  pad();
}

void PatchRows::recall(const ResidualSide& side, std::size_t begin, std::size_t end) {
  count_ = 0;
  for (std::size_t i = begin; i < end; ++i)
    if (!std::isnan(side.n[i])) take(side, count_++, static_cast<Index>(i), side.row[i]);
  pad();
}

[[gnu::always_inline]] inline void PatchRows::take(const ResidualSide& side, std::size_t k, Index i,
                                                   const ResidualRow& row) {
  const Index at = side.hint[i];
  node_[k] = i;
  vertical_[k] = row.vertical;
  area_[k] = side.weight(i) * facet_weight(*side.target, at);
  arm_x_[k] = row.arm_x, arm_y_[k] = row.arm_y, arm_z_[k] = row.arm_z;
  gx_[k] = row.smooth_gx, gy_[k] = row.smooth_gy;
  factor_[k] = side.factors()[at];
}

void PatchRows::pad() {
  padded_ = (count_ + lanes - 1) / lanes * lanes;
  for (std::size_t k = count_; k < padded_; ++k) {
    vertical_[k] = area_[k] = 0;
    arm_x_[k] = arm_y_[k] = arm_z_[k] = gx_[k] = gy_[k] = 0;
    factor_[k] = 1;
  }
}

void PatchRows::weigh(ResidualSide& side, const Loss& loss, std::size_t patch, ResidualSums& sums) {
  const double trust = side.trust[patch], bend = side.bend[patch];
  for (std::size_t k = 0; k < padded_; ++k) n_[k] = vertical_[k] * static_cast<double>(factor_[k]);
  for (std::size_t k = 0; k < count_; ++k) side.n[node_[k]] = n_[k];
  if (loss.kind == Loss::Kind::huber)
    value_huber(huber_bound * loss.scale, padded_, n_.data(), loss_.data(), weight_.data(), curvature_.data());
  else
    value_tukey(tukey_bound * loss.scale, padded_, n_.data(), loss_.data(), weight_.data(), curvature_.data());
  constexpr std::size_t two = 2;
  double area[two] = {}, lost[two] = {}, fitted[two] = {}, within[two] = {}, volume[two] = {}, squares[two] = {},
         curved[two] = {};
  for (std::size_t k = 0; k < padded_; k += two)
    for (std::size_t l = 0; l < two; ++l) {
      const double a = area_[k + l], v = vertical_[k + l], weighted = a * weight_[k + l];
      const double counted = weighted > 0 ? a : 0;
      area[l] += a;
      lost[l] += a * loss_[k + l];
      fitted[l] += weighted;
      within[l] += counted;
      volume[l] += counted * std::fabs(v);
      squares[l] += weighted * v * v;
      curved[l] += a * curvature_[k + l];
    }
  sums.area += area[0] + area[1];
  sums.trusted += trust * (area[0] + area[1]);
  sums.loss += trust * (lost[0] + lost[1]);
  sums.fitted += trust * (fitted[0] + fitted[1]);
  sums.within += trust * (within[0] + within[1]);
  sums.volume += trust * (volume[0] + volume[1]);
  sums.squares += trust * (squares[0] + squares[1]);
  sums.curvature += trust * (curved[0] + curved[1]);
  sums.bend += bend * (fitted[0] + fitted[1]);
  sums.nodes += count_;
  for (std::size_t k = 0; k < padded_; ++k) pull_[k] = static_cast<float>(trust * area_[k] * weight_[k]);
}

template <bool moving_nodes>
void PatchRows::add_equations(const View& view, ResidualSums& sums) {
  const float sign = moving_nodes ? 1 : -1, shrink = moving_nodes ? 0 : static_cast<float>(view.inverse_length);
  std::array<float, 9> r{1, 0, 0, 0, 1, 0, 0, 0, 1};
  if constexpr (!moving_nodes)
    for (std::size_t i = 0; i < 9; ++i) r[i] = static_cast<float>(view.turn[i]);
  for (std::size_t k = 0; k < padded_; ++k) {
    const float ux = -gx_[k] * factor_[k], uy = -gy_[k] * factor_[k], uz = factor_[k];
    const float nx = sign * (r[0] * ux + r[1] * uy + r[2] * uz), ny = sign * (r[3] * ux + r[4] * uy + r[5] * uz),
                nz = sign * (r[6] * ux + r[7] * uy + r[8] * uz);
    const float ax = arm_x_[k], ay = arm_y_[k], az = arm_z_[k], n = static_cast<float>(n_[k]);
    column_[0][k] = ay * nz - az * ny;
    column_[1][k] = az * nx - ax * nz;
    column_[2][k] = ax * ny - ay * nx;
    column_[3][k] = nx;
    column_[4][k] = ny;
    column_[5][k] = nz;
    column_[6][k] = ax * nx + ay * ny + az * nz + shrink * n;
    column_[7][k] = n;
  }
  double* out = sums.h.m.data();
  add_row<0>(out, sums), add_row<1>(out, sums), add_row<2>(out, sums), add_row<3>(out, sums);
  add_row<4>(out, sums), add_row<5>(out, sums), add_row<6>(out, sums);
}

/// Products of one column with itself and those after it, lane by lane.
template <std::size_t row>
void PatchRows::add_row(double*& out, ResidualSums& sums) const {
  using Lanes [[gnu::vector_size(sizeof(float) * lanes)]] = float;
  constexpr std::size_t columns = parameters + 1 - row;
  const auto load = [](const FloatColumn& column, std::size_t k) {
    Lanes v;
    __builtin_memcpy(&v, column.data() + k, sizeof v);
    return v;
  };
  Lanes sum[columns] = {};
  for (std::size_t k = 0; k < padded_; k += lanes) {
    const Lanes x = load(pull_, k) * load(column_[row], k);
    for (std::size_t c = 0; c < columns; ++c) sum[c] += x * load(column_[row + c], k);
  }
  const auto total = [](const Lanes& v) { return static_cast<double>(v[0] + v[2]) + static_cast<double>(v[1] + v[3]); };
  for (std::size_t c = 0; c + 1 < columns; ++c) *out++ += total(sum[c]);
  sums.b[row] -= total(sum[columns - 1]);
}

template void PatchRows::gather<true>(ResidualSide&, const View&, std::size_t, std::size_t, Index&, std::uint64_t&);
template void PatchRows::gather<false>(ResidualSide&, const View&, std::size_t, std::size_t, Index&, std::uint64_t&);
template void PatchRows::add_equations<true>(const View&, ResidualSums&);
template void PatchRows::add_equations<false>(const View&, ResidualSums&);

}  // namespace isopach
