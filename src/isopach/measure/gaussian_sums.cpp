#include "isopach/measure/gaussian_sums.hpp"

#include <algorithm>
#include <cmath>
#include <numbers>
#include <numeric>

#include "isopach/base/parallel.hpp"

namespace isopach {
namespace {

constexpr std::int64_t reach = GaussianBoxes::reach;
constexpr unsigned order = 12;  // Chebyshev nodes a side: the kernel is met within 2e-10 of its peak
constexpr std::size_t square = static_cast<std::size_t>(order) * order;
constexpr std::size_t x_fields = 5;  // g, ug, u²g of the weights, g, ug of the weighted heights
constexpr std::size_t fields = 9;    // GaussianMoments
constexpr double crowded = 12;       // nodes a box, on average, from which on boxes are cheaper than pairs
constexpr std::size_t most_room = std::size_t{1} << 27;  // doubles kept for the rows in reach
constexpr double thin = 1e-3;  // below this mass (π in the open) the kernel's own error would show

using Square = std::array<double, square>;
using Line = std::array<double, order>;

/// Lagrange polynomials of the Chebyshev nodes at s in [−1, 1].
class Basis {
 public:
  Basis() {
    for (unsigned k = 0; k < order; ++k) node[k] = std::cos((2 * k + 1) * std::numbers::pi / (2 * order));
    for (unsigned k = 0; k < order; ++k) chebyshev_[k] = polynomials(node[k]);
  }
  [[nodiscard]] Line at(double s) const {
    const Line t = polynomials(s);
    Line out;
    for (unsigned k = 0; k < order; ++k) {
      double sum = 0.5;
      for (unsigned j = 1; j < order; ++j) sum += chebyshev_[k][j] * t[j];
      out[k] = sum * (2.0 / order);
    }
    return out;
  }
  Line node{};

 private:
  static Line polynomials(double s) {
    Line t{1, s};
    for (unsigned j = 2; j < order; ++j) t[j] = 2 * s * t[j - 1] - t[j - 2];
    return t;
  }
  std::array<Line, order> chebyshev_{};
};

/// τⁱ exp(−τ²) from Chebyshev node k of a box `d` boxes away to node m of this one: [i][d + reach][m·order + k].
class Transfer {
 public:
  explicit Transfer(const Basis& basis) : table_(3 * (2 * reach + 1)) {
    for (std::int64_t d = -reach; d <= reach; ++d)
      for (unsigned m = 0; m < order; ++m)
        for (unsigned k = 0; k < order; ++k) {
          const double tau = static_cast<double>(d) + (basis.node[k] - basis.node[m]) / 2, g = std::exp(-tau * tau);
          for (unsigned i = 0; i < 3; ++i)
            table_[index(i, d)][m * order + k] = i == 0 ? g : i == 1 ? tau * g : tau * tau * g;
        }
  }
  [[nodiscard]] const Square& operator()(unsigned power, std::int64_t d) const { return table_[index(power, d)]; }

 private:
  static std::size_t index(unsigned power, std::int64_t d) {
    return power * static_cast<std::size_t>(2 * reach + 1) + static_cast<std::size_t>(d + reach);
  }
  std::vector<Square> table_;
};

/// out[m][l] += Σ_k t[m][k] in[k][l]: along x.
void add_along_x(const Square& t, const double* in, double* out) {
  for (unsigned m = 0; m < order; ++m)
    for (unsigned k = 0; k < order; ++k) {
      const double f = t[m * order + k];
      for (unsigned l = 0; l < order; ++l) out[m * order + l] += f * in[k * order + l];
    }
}
/// out[l'][m] += Σ_l t[l'][l] in[l][m]: along y, of squares that are kept transposed.
void add_along_y(const Square& t, const double* in, double* out) { add_along_x(t, in, out); }

void transpose(double* s) {
  for (unsigned i = 0; i < order; ++i)
    for (unsigned j = 0; j < i; ++j) std::swap(s[i * order + j], s[j * order + i]);
}

GaussianMoments pair_sums(const GaussianBoxes& b, const GaussianBoxes::Box& box, const Point2& at,
                          std::span<const double> weight, std::span<const double> weighted_z) {
  constexpr double cut = static_cast<double>(reach) * static_cast<double>(reach);
  GaussianMoments s;
  for (std::int64_t dr = -reach; dr <= reach; ++dr)
    for (const GaussianBoxes::Box& other : b.in_row(box.row + dr, box.column - reach, box.column + reach)) {
      const double du = static_cast<double>(other.column - box.column), dv = static_cast<double>(dr);
      for (std::size_t k = other.begin; k < other.end; ++k) {
        const double u = du + (b.at[k].x - at.x) / 2, v = dv + (b.at[k].y - at.y) / 2, r2 = u * u + v * v;
        if (r2 > cut) continue;
        const double g = std::exp(-r2), w = g * weight[b.nodes[k]], z = g * weighted_z[b.nodes[k]];
        s.a00 += w, s.a10 += w * u, s.a01 += w * v, s.a20 += w * u * u, s.a11 += w * u * v, s.a02 += w * v * v;
        s.z00 += z, s.z10 += z * u, s.z01 += z * v;
      }
    }
  return s;
}

/// The rows of boxes from the first to the last, each in its turn: charges of the row `reach` further on are spread
/// along x for all columns they reach, then the rows in reach are gathered along y.
class RowSweep {
 public:
  RowSweep(const GaussianBoxes& b, std::span<const double> weight, std::span<const double> weighted_z, unsigned degree,
           Array<GaussianMoments>& out)
      : b_(b), weight_(weight), weighted_z_(weighted_z), degree_(degree), transfer_(basis_), out_(out) {
    for (Row& row : ring_) {
      row.spread.resize(static_cast<std::size_t>(b.columns) * x_fields * square);
      row.reached.assign(static_cast<std::size_t>(b.columns), 0);
    }
  }

  void run(const Context& context) {
    for (std::int64_t row = -reach; row < b_.rows; ++row) {
      spread(row + reach);
      if (row >= 0) gather(row);
      context.check();
    }
  }

 private:
  struct Row {
    std::int64_t number = -1;
    Array<double> spread;                ///< [column][field][m·order + l], each square transposed
    std::vector<unsigned char> reached;  ///< by column
  };
  Row& ring(std::int64_t row) { return ring_[static_cast<std::size_t>(row % (2 * reach + 1))]; }

  void spread(std::int64_t number) {
    if (number >= b_.rows) return;
    Row& row = ring(number);
    row.number = number;
    const std::span<const GaussianBoxes::Box> boxes = b_.in_row(number, 0, b_.columns - 1);
    Array<double> charges(boxes.size() * 2 * square);
    for_blocks(boxes.size(), 16, [&](std::size_t begin, std::size_t end) {
      for (std::size_t i = begin; i < end; ++i) collect(boxes[i], &charges[i * 2 * square]);
    });
    for_blocks(static_cast<std::size_t>(b_.columns), 16, [&](std::size_t begin, std::size_t end) {
      for (std::size_t column = begin; column < end; ++column) {
        const auto c = static_cast<std::int64_t>(column);
        const std::span<const GaussianBoxes::Box> near = b_.in_row(number, c - reach, c + reach);
        row.reached[column] = near.empty() ? 0 : 1;
        if (near.empty()) continue;
        double* out = &row.spread[column * x_fields * square];
        std::fill(out, out + x_fields * square, 0.0);
        for (const GaussianBoxes::Box& box : near) {
          const double* q = &charges[static_cast<std::size_t>(&box - boxes.data()) * 2 * square];
          const std::int64_t d = box.column - c;
          add_along_x(transfer_(0, d), q, out);
          add_along_x(transfer_(0, d), q + square, out + 3 * square);
          if (degree_ == 0) continue;
          add_along_x(transfer_(1, d), q, out + square);
          add_along_x(transfer_(2, d), q, out + 2 * square);
          add_along_x(transfer_(1, d), q + square, out + 4 * square);
        }
        for (std::size_t f = 0; f < x_fields; ++f) transpose(out + f * square);
      }
    });
  }

  void collect(const GaussianBoxes::Box& box, double* q) const {
    std::fill(q, q + 2 * square, 0.0);
    for (std::size_t i = box.begin; i < box.end; ++i) {
      const Line x = basis_.at(b_.at[i].x), y = basis_.at(b_.at[i].y);
      const double w = weight_[b_.nodes[i]], z = weighted_z_[b_.nodes[i]];
      for (unsigned k = 0; k < order; ++k)
        for (unsigned l = 0; l < order; ++l) {
          q[k * order + l] += w * x[k] * y[l];
          q[square + k * order + l] += z * x[k] * y[l];
        }
    }
  }

  void gather(std::int64_t number) {
    const std::span<const GaussianBoxes::Box> boxes = b_.in_row(number, 0, b_.columns - 1);
    for_blocks(boxes.size(), 4, [&](std::size_t begin, std::size_t end) {
      std::array<double, fields * square> f{};
      for (std::size_t i = begin; i < end; ++i) {
        f.fill(0);
        for (std::int64_t d = -reach; d <= reach; ++d) add_row(number, d, boxes[i].column, f);
        evaluate(boxes[i], f);
      }
    });
  }

  void add_row(std::int64_t number, std::int64_t d, std::int64_t column, std::array<double, fields * square>& f) {
    if (number + d < 0 || number + d >= b_.rows) return;
    const Row& row = ring(number + d);
    if (row.reached[static_cast<std::size_t>(column)] == 0) return;
    const double* x = &row.spread[static_cast<std::size_t>(column) * x_fields * square];
    const auto add = [&](unsigned power, std::size_t from, std::size_t to) {
      add_along_y(transfer_(power, d), x + from * square, &f[to * square]);
    };
    add(0, 0, 0), add(0, 3, 6);
    if (degree_ == 0) return;
    add(0, 1, 1), add(1, 0, 2), add(0, 2, 3), add(1, 1, 4), add(2, 0, 5);
    add(0, 4, 7), add(1, 3, 8);
  }

  void evaluate(const GaussianBoxes::Box& box, const std::array<double, fields * square>& f) {
    for (std::size_t i = box.begin; i < box.end; ++i) {
      const Line x = basis_.at(b_.at[i].x), y = basis_.at(b_.at[i].y);
      std::array<double, fields> value{};
      for (std::size_t field = 0; field < fields; ++field) {
        if (degree_ == 0 && field != 0 && field != 6) continue;
        for (unsigned l = 0; l < order; ++l) {
          double along = 0;
          for (unsigned m = 0; m < order; ++m) along += x[m] * f[field * square + l * order + m];
          value[field] += y[l] * along;
        }
      }
      out_[i] = value[0] < thin ? pair_sums(b_, box, b_.at[i], weight_, weighted_z_)
                                : GaussianMoments{value[0], value[1], value[2], value[3], value[4],
                                                  value[5], value[6], value[7], value[8]};
    }
  }

  const GaussianBoxes& b_;
  std::span<const double> weight_, weighted_z_;
  unsigned degree_;
  Basis basis_;
  Transfer transfer_;
  std::array<Row, static_cast<std::size_t>(2 * reach + 1)> ring_;
  Array<GaussianMoments>& out_;
};

bool use_boxes(const GaussianBoxes& b, GaussianMethod method) {
  if (method != GaussianMethod::automatic) return method == GaussianMethod::boxes;
  const auto room = static_cast<double>(b.columns) * static_cast<double>((2 * reach + 1) * x_fields * square);
  return static_cast<double>(b.nodes.size()) > crowded * static_cast<double>(b.boxes.size()) &&
         room < static_cast<double>(most_room) && b.rows < std::int64_t{1} << 24;
}

}  // namespace

GaussianBoxes::GaussianBoxes(std::span<const Point2> xy, std::span<const double> weight, double width) {
  Box2 bounds;
  for (std::size_t i = 0; i < xy.size(); ++i)
    if (weight[i] > 0) bounds.add(xy[i]), nodes.push_back(static_cast<Index>(i));
  if (nodes.empty()) return;
  const auto cell = [&](double x, double low) { return static_cast<std::int64_t>(std::floor((x - low) / width)); };
  rows = cell(bounds.max.y, bounds.min.y) + 1;
  columns = cell(bounds.max.x, bounds.min.x) + 1;
  struct Place {
    std::int64_t row, column;
  };
  Array<Place> place(xy.size());
  for (const Index i : nodes) place[i] = {cell(xy[i].y, bounds.min.y), cell(xy[i].x, bounds.min.x)};
  std::stable_sort(nodes.begin(), nodes.end(), [&](Index i, Index j) {
    return place[i].row != place[j].row ? place[i].row < place[j].row : place[i].column < place[j].column;
  });
  at.resize(nodes.size());
  for (std::size_t k = 0; k < nodes.size(); ++k) {
    const Place p = place[nodes[k]];
    if (boxes.empty() || boxes.back().row != p.row || boxes.back().column != p.column)
      boxes.push_back({p.row, p.column, k, k});
    ++boxes.back().end;
    const auto inside = [&](double x, double low, std::int64_t number) {
      return std::clamp(2 * ((x - low) / width - static_cast<double>(number)) - 1, -1.0, 1.0);
    };
    at[k] = {inside(xy[nodes[k]].x, bounds.min.x, p.column), inside(xy[nodes[k]].y, bounds.min.y, p.row)};
  }
}

std::span<const GaussianBoxes::Box> GaussianBoxes::in_row(std::int64_t row, std::int64_t first,
                                                          std::int64_t last) const {
  const auto before = [](const Box& box, const std::pair<std::int64_t, std::int64_t>& key) {
    return box.row != key.first ? box.row < key.first : box.column < key.second;
  };
  const auto begin = std::lower_bound(boxes.begin(), boxes.end(), std::pair{row, first}, before);
  const auto end = std::lower_bound(begin, boxes.end(), std::pair{row, last + 1}, before);
  return {begin, end};
}

Array<GaussianMoments> gaussian_moments(const GaussianBoxes& b, std::span<const double> weight,
                                        std::span<const double> weighted_z, unsigned degree, GaussianMethod method,
                                        const Context& context) {
  Array<GaussianMoments> out(b.nodes.size());
  if (use_boxes(b, method)) {
    RowSweep(b, weight, weighted_z, degree, out).run(context);
    return out;
  }
  for_blocks(b.boxes.size(), 64, [&](std::size_t begin, std::size_t end) {
    context.check();
    for (std::size_t i = begin; i < end; ++i)
      for (std::size_t k = b.boxes[i].begin; k < b.boxes[i].end; ++k)
        out[k] = pair_sums(b, b.boxes[i], b.at[k], weight, weighted_z);
  });
  return out;
}

}  // namespace isopach
