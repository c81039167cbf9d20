#include "isopach/measure/texture/form.hpp"

#include <algorithm>
#include <array>

#include <fmt/format.h>

#include "isopach/base/error.hpp"
#include "isopach/base/linear.hpp"
#include "isopach/base/parallel.hpp"
#include "isopach/base/sum.hpp"

namespace isopach {
namespace {

constexpr std::size_t block = 1 << 14;
constexpr std::size_t most_terms = (most_form_degree + 1) * (most_form_degree + 2) / 2;

struct Equations {
  std::vector<Sum> gram, right;  // gram: the lower triangle, row by row
};

void legendre(double t, unsigned degree, double* p) {
  p[0] = 1;
  if (degree > 0) p[1] = t;
  for (unsigned k = 2; k <= degree; ++k) p[k] = ((2 * k - 1) * t * p[k - 1] - (k - 1) * p[k - 2]) / k;
}

Equations equations(const Form& form, std::span<const Point2> xy, std::span<const double> area,
                    std::span<const double> z) {
  const std::size_t terms = Form::terms(form.degree());
  return reduce_blocks<Equations>(
      xy.size(), block,
      [&](std::size_t begin, std::size_t end) {
        Equations e{std::vector<Sum>(terms * (terms + 1) / 2), std::vector<Sum>(terms)};
        std::array<double, most_terms> b{};
        for (std::size_t i = begin; i < end; ++i) {
          if (!(area[i] > 0)) continue;
          form.basis(xy[i], b);
          const double rest = z[i] - form.at(xy[i]);
          for (std::size_t r = 0, k = 0; r < terms; ++r) {
            const double weighted = area[i] * b[r];
            e.right[r].add(weighted * rest);
            for (std::size_t c = 0; c <= r; ++c) e.gram[k++].add(weighted * b[c]);
          }
        }
        return e;
      },
      [](Equations& total, const Equations& part) {
        if (total.right.empty()) {
          total = part;
          return;
        }
        for (std::size_t k = 0; k < part.gram.size(); ++k) total.gram[k].add(part.gram[k]);
        for (std::size_t k = 0; k < part.right.size(); ++k) total.right[k].add(part.right[k]);
      });
}

}  // namespace

Form::Form(unsigned degree, const Box2& box) : coefficients(terms(degree), 0.0), degree_(degree) {
  if (box.empty()) return;
  middle_ = {box.min.x + (box.max.x - box.min.x) / 2, box.min.y + (box.max.y - box.min.y) / 2};
  const double x = (box.max.x - box.min.x) / 2, y = (box.max.y - box.min.y) / 2;
  half_ = {x > 0 ? x : 1, y > 0 ? y : 1};
}

void Form::basis(const Point2& p, std::span<double> values) const {
  std::array<double, most_form_degree + 1> x{}, y{};
  legendre((p.x - middle_.x) / half_.x, degree_, x.data());
  legendre((p.y - middle_.y) / half_.y, degree_, y.data());
  std::size_t k = 0;
  for (unsigned d = 0; d <= degree_; ++d)
    for (unsigned j = 0; j <= d; ++j) values[k++] = x[d - j] * y[j];
}

double Form::at(const Point2& p) const {
  std::array<double, most_terms> b{};
  basis(p, b);
  double sum = 0;
  for (std::size_t k = 0; k < coefficients.size(); ++k) sum += coefficients[k] * b[k];
  return sum;
}

Form fit_form(std::span<const Point2> xy, std::span<const double> area, std::span<const double> z, unsigned degree,
              const Context& context) {
  if (degree > most_form_degree)
    throw UsageError(fmt::format("a form of degree {}: choose 0 to {}", degree, most_form_degree));
  Box2 box;
  for (std::size_t i = 0; i < xy.size(); ++i)
    if (area[i] > 0) box.add(xy[i]);
  Form form(degree, box);
  if (box.empty()) return form;
  const auto terms = static_cast<Eigen::Index>(Form::terms(degree));
  for (int pass = 0; pass < 2; ++pass) {  // the second takes what rounding left of the first
    context.check();
    const Equations e = equations(form, xy, area, z);
    Eigen::MatrixXd gram(terms, terms);
    Eigen::VectorXd right(terms);
    for (Eigen::Index r = 0, k = 0; r < terms; ++r) {
      right(r) = e.right[static_cast<std::size_t>(r)].value();
      for (Eigen::Index c = 0; c <= r; ++c) gram(r, c) = gram(c, r) = e.gram[static_cast<std::size_t>(k++)].value();
    }
    const Eigen::VectorXd step = least_norm(gram, right, 1e-12);
    for (Eigen::Index k = 0; k < terms; ++k) form.coefficients[static_cast<std::size_t>(k)] += step(k);
  }
  return form;
}

}  // namespace isopach
